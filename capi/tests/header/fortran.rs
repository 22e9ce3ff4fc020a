//! Makes the module for Fortran of the header: an interface for each function, a type for each struct, and the numbers of its version.
//!
//! How C is said in Fortran: a handle is a `type(c_ptr)` by value; a place for a handle or a pointer is a `type(c_ptr)` that is set; a text is an array of
//! characters that ends with `c_null_char`; `size_t *`, and a struct that is filled, is one value; any other pointer is an array.

/// What ends the module: texts of C as those of Fortran.
const TEXTS: &str = "\
contains

  ! The characters of a text of the library, which ends with a zero byte; none for NULL.
  function hexcast_text(text) result(letters)
    type(c_ptr), intent(in) :: text
    character(len=:), allocatable :: letters
    character(kind=c_char), pointer :: bytes(:)
    integer :: i
    letters = ''
    if (.not. c_associated(text)) return
    call c_f_pointer(text, bytes, [hexcast_strlen(text)])
    allocate (character(len=size(bytes)) :: letters)
    do i = 1, size(bytes)
      letters(i:i) = bytes(i)
    end do
  end function

  ! The first cell of a run, counted from 0.
  elemental integer(c_int32_t) function hexcast_run_first(run)
    integer(c_int32_t), intent(in) :: run
    hexcast_run_first = ishft(run, -8)
  end function

  ! The flag of a run, 0 to 255.
  elemental integer(c_int32_t) function hexcast_run_flag(run)
    integer(c_int32_t), intent(in) :: run
    hexcast_run_flag = iand(run, 255_c_int32_t)
  end function
end module
";

/// The interface of what `hexcast_text` needs.
const STRLEN: &str = "    function hexcast_strlen(text) bind(c, name='strlen')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
      integer(c_size_t) :: hexcast_strlen
    end function
";

/// The module.
pub(crate) fn module(header: &str) -> String {
    let mut out = String::from("! hexcast.f90: the functions of hexcast.h, which documents them, for Fortran.\n!\n");
    out += "! Made of hexcast.h by capi/tests/header: do not edit. Unsigned numbers have a sign here: flags above 127 are negative in 8 bits.\n\n";
    out += "module hexcast\n  use, intrinsic :: iso_c_binding\n  implicit none\n\n";
    out += &version(header);
    let code: String =
        header.lines().filter(|line| !line.trim_start().starts_with("//")).map(|line| format!("{line}\n")).collect();
    out += &structs(&code);
    out += "  abstract interface\n";
    out += &interface("hexcast_progress", "bind(c)", "int32_t", &arguments_of(&code, "(*HexcastProgress)("));
    out += "  end interface\n\n  interface\n";
    for (result, name) in functions(&code) {
        let bind = format!("bind(c, name='{name}')");
        out += &interface(name, &bind, result, &arguments_of(&code, &format!("{name}(")));
        out.push('\n');
    }
    out + STRLEN + "  end interface\n\n" + TEXTS
}

fn version(header: &str) -> String {
    let mut out = String::new();
    for line in header.lines().filter_map(|line| line.strip_prefix("#define HEXCAST_VERSION_")) {
        let (name, value) = line.split_once(' ').expect("a name and a value");
        let name = name.to_ascii_lowercase();
        out += &match value.starts_with('"') {
            true => format!("  character(len=*), parameter :: hexcast_version_{name} = {}\n", value.replace('"', "'")),
            false => format!("  integer, parameter :: hexcast_version_{name} = {value}\n"),
        };
    }
    out + "\n"
}

/// Those structs whose fields callers know.
fn structs(code: &str) -> String {
    let mut out = String::new();
    for of in code.split("typedef struct ").skip(1) {
        let Some((name, body)) = of.split_once('{').filter(|(name, _)| !name.contains(';')) else { continue };
        let (fields, _) = body.split_once('}').expect("a struct ends");
        out += &format!("  type, bind(c) :: {}\n", fortran_name(name.trim()));
        for field in fields.split(';').map(str::trim).filter(|field| !field.is_empty()) {
            let (c_type, name) = split(field);
            let (name, dims) =
                name.split_once('[').map_or((name, ""), |(name, length)| (name, length.trim_end_matches(']')));
            let dims = if dims.is_empty() { String::new() } else { format!("({dims})") };
            let (kind, initial) = match c_type.contains('*') {
                true => ("type(c_ptr)".to_string(), " = c_null_ptr"),
                false if dims.is_empty() => (number(c_type), " = 0"),
                false => (number(c_type), ""),
            };
            out += &format!("    {kind} :: {name}{dims}{initial}\n");
        }
        out += "  end type\n\n";
    }
    out
}

/// Result and name of every function, in their order.
pub(crate) fn functions(code: &str) -> Vec<(&str, &str)> {
    let begins = code.lines().filter(|line| !line.starts_with([' ', '#', '}', '/']) && !line.starts_with("typedef"));
    let heads = begins.filter_map(|line| line.split_once('(').map(|(head, _)| head));
    heads.filter(|head| head.contains("hexcast_")).map(split).collect()
}

/// Type and name of each argument of what is declared so.
fn arguments_of<'a>(code: &'a str, declared: &str) -> Vec<(&'a str, &'a str)> {
    let start = code.find(declared).expect("it is declared") + declared.len();
    let (arguments, _) = code[start..].split_once(')').expect("arguments end");
    arguments.split(',').map(str::trim).filter(|argument| *argument != "void").map(split).collect()
}

/// Type and name of a declaration.
fn split(declaration: &str) -> (&str, &str) {
    let is_of_name = |letter: char| letter.is_ascii_alphanumeric() || "_[]".contains(letter);
    let at = declaration.trim_end_matches(is_of_name).len();
    (declaration[..at].trim(), &declaration[at..])
}

/// An interface, whose function is a subroutine where it returns nothing.
fn interface(name: &str, bind: &str, result: &str, arguments: &[(&str, &str)]) -> String {
    let kind = if result == "void" { "subroutine" } else { "function" };
    let names: Vec<&str> = arguments.iter().map(|(_, name)| *name).collect();
    let mut out = format!("    {kind} {name}({}) &\n      {bind}\n", names.join(", "));
    let lines: Vec<String> = arguments.iter().map(|(c_type, name)| argument(c_type, name)).collect();
    let result = match result {
        "void" => None,
        _ if result.contains('*') => Some(format!("type(c_ptr) :: {name}")),
        _ => Some(format!("{} :: {name}", number(result))),
    };
    let lines: Vec<String> = lines.into_iter().chain(result).collect();
    let kinds = ["c_ptr", "c_funptr", "c_char", "c_double", "c_size_t", "c_int8_t", "c_int32_t", "c_int64_t"];
    let types = ["hexcast_array", "hexcast_columns", "hexcast_facets"];
    let used = |kind: &&&str| {
        lines.iter().any(|line| line.contains(&format!("({kind})")) || line.contains(&format!("={kind})")))
    };
    let used: Vec<&str> = kinds.iter().chain(&types).filter(used).copied().collect();
    if !used.is_empty() {
        out += &format!("      import :: {}\n", used.join(", "));
    }
    lines.iter().for_each(|line| out += &format!("      {line}\n"));
    out + &format!("    end {kind}\n")
}

/// The declaration of an argument.
fn argument(c_type: &str, name: &str) -> String {
    let is_const = c_type.starts_with("const ");
    let pointed = c_type.trim_start_matches("const ").trim_start_matches("struct ");
    let intent = if is_const { "intent(in)" } else { "intent(out)" };
    match pointed.replace(' ', "").as_str() {
        "HexcastProgress" => format!("type(c_funptr), value :: {name}"),
        // it is left as it is where nothing fails
        "HexcastError**" => format!("type(c_ptr), intent(inout) :: {name}"),
        "HexcastMesh*" | "HexcastMesher*" | "HexcastScene*" | "HexcastError*" | "void*" => {
            format!("type(c_ptr), value :: {name}")
        }
        "HexcastFacets*" => format!("type(hexcast_facets), intent(in) :: {name}(*)"),
        of if of.ends_with("**") => format!("type(c_ptr), intent(out) :: {name}"),
        of if of.starts_with("Hexcast") && of.ends_with('*') => {
            format!("type({}), {intent} :: {name}", fortran_name(of.trim_end_matches('*')))
        }
        "char*" => format!("character(kind=c_char), {intent} :: {name}(*)"),
        "size_t*" => format!("integer(c_size_t), {intent} :: {name}"),
        of if of.ends_with('*') => format!("{}, {intent} :: {name}(*)", number(of.trim_end_matches('*'))),
        of => format!("{}, value :: {name}", number(of)),
    }
}

/// A type of numbers or letters.
fn number(c_type: &str) -> String {
    match c_type.trim() {
        "double" => "real(c_double)",
        "char" => "character(kind=c_char)",
        "size_t" => "integer(c_size_t)",
        "uint8_t" => "integer(c_int8_t)",
        "uint32_t" | "int32_t" => "integer(c_int32_t)",
        "uint64_t" => "integer(c_int64_t)",
        other => panic!("no type of Fortran for {other}"),
    }
    .to_string()
}

/// `HexcastChangedRun` is `hexcast_changed_run`.
fn fortran_name(name: &str) -> String {
    let snake: String = name
        .chars()
        .flat_map(|letter| [letter.is_uppercase().then_some('_'), Some(letter.to_ascii_lowercase())])
        .flatten()
        .collect();
    snake.trim_start_matches('_').to_string()
}
