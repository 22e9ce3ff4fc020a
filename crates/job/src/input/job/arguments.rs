//! What the command line needs of a job: headings of its help, and numbers as people write them: 256, 1e6, 0.5, or several separated by commas.

use std::fmt::Display;

use super::PerAxis;

/// Heading in the help of what says where the cells are.
pub const CELLS: &str = "Cells and domain";
/// Heading of what decides cells, and by what means.
pub const METHOD: &str = "Method";
/// Heading of limits of memory.
pub const MEMORY: &str = "Memory";
/// Heading of what says how files are written.
pub const OUTPUT: &str = "Output";

/// A kind of number that arguments have.
pub trait Number: Sized {
    /// Reads one; the error is a sentence.
    fn read(text: &str) -> Result<Self, String>;
}

impl Number for f64 {
    fn read(text: &str) -> Result<f64, String> {
        text.parse().map_err(|_| {
            let unit = text.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+'));
            let number = &text[..text.len() - unit.len()];
            if number.parse::<f64>().is_ok() && unit.trim().chars().all(char::is_alphabetic) {
                let unit = unit.trim();
                return format!(
                    "\"{text}\" has a unit: lengths are in that of the files. Write {number}, and --unit {unit} if the files are in {unit}"
                );
            }
            format!("\"{text}\" is not a number")
        })
    }
}

macro_rules! whole {
    ($($kind:ty),*) => {
        $(impl Number for $kind {
            fn read(text: &str) -> Result<$kind, String> {
                whole(text, u64::from(<$kind>::MAX)).map(|number| number as $kind)
            }
        })*
    };
}
whole!(u8, u16, u32, u64);

/// Reads a whole number from 0 to `most`, also as 1e6 or 2.5e6.
fn whole(text: &str, most: u64) -> Result<u64, String> {
    if let Ok(number) = text.parse::<u64>() {
        return in_range(text, Some(number), most);
    }
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let (number, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let (digits, fraction) = number.split_once('.').unwrap_or((number, ""));
    let is_number = is_digits(digits) && (fraction.is_empty() || is_digits(fraction)) && is_digits(exponent);
    if !is_number {
        let is_real = text.parse::<f64>().is_ok_and(f64::is_finite);
        let range = range(most);
        let problem = if is_real { format!("not {range}") } else { format!("not a number: {range} is needed") };
        return Err(format!("\"{text}\" is {problem}"));
    }
    let fraction = fraction.trim_end_matches('0');
    let power = exponent.parse::<u32>().ok().and_then(|exponent| exponent.checked_sub(fraction.len() as u32));
    let digits = format!("{digits}{fraction}").parse::<u64>().ok();
    match (power, digits) {
        (None, _) if exponent.len() < 4 => Err(format!("\"{text}\" is not {}", range(most))),
        (power, digits) => {
            let number = digits.zip(power).and_then(|(digits, power)| digits.checked_mul(10u64.checked_pow(power)?));
            in_range(text, number, most)
        }
    }
}

fn in_range(text: &str, number: Option<u64>, most: u64) -> Result<u64, String> {
    number.filter(|number| *number <= most).ok_or_else(|| format!("\"{text}\" is too large: {} is needed", range(most)))
}

fn range(most: u64) -> String {
    format!("a whole number from 0 to {most}")
}

/// Reads a number.
pub fn number<T: Number>(text: &str) -> Result<T, String> {
    T::read(text.trim())
}

/// Reads a number of at least 1.
pub fn at_least_one<T: Number + PartialEq + Default + Display>(text: &str) -> Result<T, String> {
    let number = number::<T>(text).map_err(|problem| problem.replace("from 0 to", "from 1 to"))?;
    if number == T::default() { Err("it is 0, and at least 1 is needed".into()) } else { Ok(number) }
}

/// Reads N numbers separated by commas, or by spaces within quotes.
pub fn list<T: Number, const N: usize>(text: &str) -> Result<[T; N], String> {
    let parts: Vec<&str> =
        if text.contains(',') { text.split(',').collect() } else { text.split_whitespace().collect() };
    let values: Vec<T> = parts.into_iter().map(number).collect::<Result<_, _>>()?;
    let found = values.len();
    <[T; N]>::try_from(values).map_err(|_| {
        let were = if found == 1 { "was" } else { "were" };
        format!("{N} numbers separated by commas are needed, and {found} {were} given")
    })
}

/// Reads one number for all axes, or three.
pub fn per_axis<T: Number>(text: &str) -> Result<PerAxis<T>, String> {
    if text.contains(',') {
        return list::<T, 3>(text).map(PerAxis::Each);
    }
    number(text).map(PerAxis::All)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_read_as_people_write_them() {
        let table = [
            ("0", 0),
            ("256", 256),
            ("1e2", 100),
            ("2.5E3", 2500),
            ("1.50e1", 15),
            ("4294967295", u32::MAX),
            ("7.0", 7),
        ];
        for (text, expected) in table {
            assert_eq!(number::<u32>(text), Ok(expected), "{text}");
        }
        let wrong = [
            ("-5", "\"-5\" is not a whole number from 0 to 4294967295"),
            ("2.5", "\"2.5\" is not a whole number from 0 to 4294967295"),
            ("1.25e1", "\"1.25e1\" is not a whole number from 0 to 4294967295"),
            ("4294967296", "\"4294967296\" is too large: a whole number from 0 to 4294967295 is needed"),
            ("1e99", "\"1e99\" is too large: a whole number from 0 to 4294967295 is needed"),
            ("1e99999999999", "\"1e99999999999\" is too large: a whole number from 0 to 4294967295 is needed"),
            ("", "\"\" is not a number: a whole number from 0 to 4294967295 is needed"),
            ("many", "\"many\" is not a number: a whole number from 0 to 4294967295 is needed"),
            ("nan", "\"nan\" is not a number: a whole number from 0 to 4294967295 is needed"),
        ];
        for (text, problem) in wrong {
            assert_eq!(number::<u32>(text), Err(problem.into()), "{text}");
        }
        assert_eq!(at_least_one::<u64>("2e12"), Ok(2_000_000_000_000));
        assert!(at_least_one::<u32>("0").is_err());
        assert!(at_least_one::<u8>("300").unwrap_err().contains("from 1 to 255"));
    }

    #[test]
    fn a_length_with_a_unit_says_where_the_unit_goes() {
        assert_eq!(number::<f64>("-1.5e-3"), Ok(-1.5e-3));
        let said = number::<f64>("0.1mm").unwrap_err();
        assert!(said.contains("Write 0.1, and --unit mm"), "{said}");
        assert_eq!(number::<f64>("wide"), Err("\"wide\" is not a number".into()));
        assert_eq!(list::<f64, 3>("1,2"), Err("3 numbers separated by commas are needed, and 2 were given".into()));
        assert_eq!(list::<f64, 3>("-1 2  3e1"), Ok([-1.0, 2.0, 30.0]));
        assert_eq!(list::<u32, 3>("1, 2, 3"), Ok([1, 2, 3]));
        assert!(list::<u32, 3>("").is_err());
    }
}
