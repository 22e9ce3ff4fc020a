//! The GLSL of the page's 3-D view beside the WGSL that it is translated from: WebGL 2 has no other language. `HEXCAST_BLESS=1` writes it.

use std::path::{Path, PathBuf};

use naga::ShaderStage;
use naga::back::glsl::{Options, PipelineOptions, Version, Writer, WriterFlags};
use naga::proc::BoundsCheckPolicies;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

/// Stages of the picture, which entry points and files are named like.
const STAGES: [(&str, ShaderStage); 2] = [("vertex", ShaderStage::Vertex), ("fragment", ShaderStage::Fragment)];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/picture")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn module() -> (naga::Module, ModuleInfo) {
    let text = read(&folder().join("cast.wgsl"));
    let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    let valid = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    let info = valid.unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    (module, info)
}

/// GLSL ES 3.00 of a stage; the picture is not turned over.
fn translated(module: &naga::Module, info: &ModuleInfo, entry_point: &str, shader_stage: ShaderStage) -> String {
    let version = Version::Embedded { version: 300, is_webgl: true };
    let options = Options { version, writer_flags: WriterFlags::empty(), ..Options::default() };
    let pipeline = PipelineOptions { shader_stage, entry_point: entry_point.into(), multiview: None };
    let mut text = String::new();
    let policies = BoundsCheckPolicies::default();
    let mut writer = Writer::new(&mut text, module, info, &options, &pipeline, policies).unwrap();
    writer.write().unwrap();
    text
}

#[test]
fn the_glsl_of_the_picture_is_the_translation_of_its_wgsl() {
    let (module, info) = module();
    for (name, stage) in STAGES {
        let text = translated(&module, &info, name, stage);
        let path = folder().join(format!("cast.{name}.glsl"));
        if std::env::var_os("HEXCAST_BLESS").is_some() {
            assert!(std::env::var_os("CI").is_none(), "CI blesses nothing");
            std::fs::write(&path, &text).unwrap();
        }
        assert!(read(&path) == text, "{} is not the translation: HEXCAST_BLESS=1 writes it anew", path.display());
    }
}
