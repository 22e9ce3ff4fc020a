//! What a geometry is made of: numbers for solvers, which hexcast passes on and does not use.

use serde::{Deserialize, Serialize};

/// Properties of a substance, all optional, in SI units whatever the unit of lengths.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Material {
    /// Relative permittivity, positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eps_r: Option<f64>,
    /// Relative permeability, positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mu_r: Option<f64>,
    /// Electric conductivity in S/m, 0 or positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma: Option<f64>,
    /// Whether it is a perfect electric conductor: JSON has no infinite `sigma`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub pec: bool,
    /// Density in kg/m3, positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Young's modulus in Pa, positive.
    #[serde(rename = "E", skip_serializing_if = "Option::is_none")]
    pub youngs_modulus: Option<f64>,
    /// Poisson's ratio, greater than -1 and less than 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nu: Option<f64>,
}

impl Material {
    /// Names of the keys in jobs.
    pub const KEYS: [&str; 7] = ["eps_r", "mu_r", "sigma", "pec", "density", "E", "nu"];

    /// Whether nothing is known of it.
    pub fn is_empty(&self) -> bool {
        *self == Material::default()
    }

    /// The same keys as JSON, for formats that take texts; None where nothing is known.
    #[doc(hidden)]
    pub fn json(&self) -> Option<String> {
        if self.is_empty() { None } else { serde_json::to_string(self).ok() }
    }

    /// The place of a number by its key in jobs.
    pub(crate) fn number_mut(&mut self, key: &str) -> Option<&mut Option<f64>> {
        match key {
            "eps_r" => Some(&mut self.eps_r),
            "mu_r" => Some(&mut self.mu_r),
            "sigma" => Some(&mut self.sigma),
            "density" => Some(&mut self.density),
            "E" => Some(&mut self.youngs_modulus),
            "nu" => Some(&mut self.nu),
            _ => None,
        }
    }

    /// The first value out of its range: its key, the value, and what is allowed.
    #[doc(hidden)]
    pub fn out_of_range(&self) -> Option<(&'static str, f64, &'static str)> {
        let positive = |value: f64| value > 0.0;
        let checks: [(_, _, &dyn Fn(f64) -> bool, _); 6] = [
            ("eps_r", self.eps_r, &positive, "a positive number"),
            ("mu_r", self.mu_r, &positive, "a positive number"),
            ("sigma", self.sigma, &|value| value >= 0.0, "0 or a positive number; of a perfect conductor pec = true"),
            ("density", self.density, &positive, "a positive number"),
            ("E", self.youngs_modulus, &positive, "a positive number"),
            ("nu", self.nu, &|value| value > -1.0 && value < 0.5, "a number between -1 and 0.5"),
        ];
        let wrong =
            checks.into_iter().find(|(_, value, is_right, _)| value.is_some_and(|v| !(v.is_finite() && is_right(v))));
        wrong.map(|(key, value, _, allowed)| (key, value.unwrap_or_default(), allowed))
    }
}
