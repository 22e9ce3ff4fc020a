//! The public API is the one that `docs/api.txt` lists, so that every change of it shows.
//!
//! The list comes from the source, read with syn: what is public natively, and not hidden. Methods of a type are listed below it,
//! wherever their `impl` is. After a change write it with `HEXCAST_BLESS=1 cargo test --test native public_api`, which is
//! refused where `CI` is set.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use quote::ToTokens;
use syn::{Attribute, Fields, ImplItem, Item, Meta, TraitItem, Type, UsePath, UseTree, Visibility};

/// The files of all crates by the paths of their modules, such as `["cells", "columns", "run"]`: the core's begin with their group, those of
/// the other crates with [`DERIVED`], [`FILES`] and [`GPU`].
type Modules = BTreeMap<Vec<String>, Vec<Item>>;

/// What the modules of these crates begin with.
/// The crates whose groups are those of one.
const ROOTS: [&str; 3] = ["crate", "hexcast_job", "hexcast_core"];
const DERIVED: &str = "derived";
const FILES: &str = "files";
const GPU: &str = "gpu";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

/// Reads a file and those of its modules, which are in `folder`.
fn read(path: &Path, folder: &Path, module: &[String], modules: &mut Modules) {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let items = syn::parse_file(&text).expect("the source is Rust").items;
    // what a macro makes of an enumeration has its name and variants
    let made = |item: &Item| match item {
        Item::Macro(of) => syn::parse2(of.mac.tokens.clone()).ok().map(Item::Enum),
        _ => None,
    };
    let items = items.into_iter().map(|item| made(&item).unwrap_or(item)).collect();
    read_items(items, folder, module, modules);
}

/// Reads the files of the modules among items; a group of `lib.rs`, whose modules are listed in its braces, among them.
fn read_items(items: Vec<Item>, folder: &Path, module: &[String], modules: &mut Modules) {
    for item in &items {
        let Item::Mod(found) = item else { continue };
        let name = found.ident.to_string();
        let (inner, file) = ([module, std::slice::from_ref(&name)].concat(), folder.join(&name));
        match &found.content {
            Some((_, listed)) if module.is_empty() => read_items(listed.clone(), &file, &inner, modules),
            None if is_there(&found.attrs) => read(&file.with_extension("rs"), &file, &inner, modules),
            _ => {}
        }
    }
    modules.entry(module.to_vec()).or_default().extend(items);
}

/// Whether an item is there natively without tests.
fn is_there(attributes: &[Attribute]) -> bool {
    attributes.iter().all(|attribute| {
        let text = text_of(&attribute.meta);
        let is_off = text.starts_with("cfg")
            && !text.starts_with("cfg_attr")
            && !text.contains("not(")
            && ["test", "wasm32"].iter().any(|word| text.contains(word));
        !is_off
    })
}

/// Whether it is in the documentation, too.
fn is_listed(attributes: &[Attribute]) -> bool {
    is_there(attributes) && !attributes.iter().any(|attribute| text_of(&attribute.meta) == "doc(hidden)")
}

/// Code as text, with the spaces that people write.
fn text_of(tokens: &impl ToTokens) -> String {
    let mut text = tokens.to_token_stream().to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    for (from, to) in [
        (" :: ", "::"),
        (" ::", "::"),
        ("& ", "&"),
        (" < ", "<"),
        (" <", "<"),
        ("< ", "<"),
        (" > ", "> "),
        (" >", ">"),
        (" ,", ","),
        (" :", ":"),
        (" ;", ";"),
        (" (", "("),
        ("( ", "("),
        (" )", ")"),
        ("[ ", "["),
        (" ]", "]"),
        (" !", "!"),
        ("' ", "'"),
        ("->", "-> "),
        ("->  ", "-> "),
        ("Fn(", "Fn("),
        (" ->", " ->"),
        ("mut(", "mut ("),
        ("fn(", "fn("),
        (")->", ") ->"),
        (",)", ")"),
    ] {
        text = text.replace(from, to);
    }
    text
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

/// What an attribute says that callers depend on: derived traits, and whether there may be more fields.
fn promises(attributes: &[Attribute]) -> String {
    let of = |attribute: &Attribute| match &attribute.meta {
        Meta::List(list) if list.path.is_ident("derive") => Some(format!(" [{}]", text_of(&list.tokens))),
        Meta::Path(path) if path.is_ident("non_exhaustive") => Some(" [non_exhaustive]".into()),
        _ => None,
    };
    attributes.iter().filter_map(of).collect()
}

/// The paths that a `pub use` names, `self` left out; what it renames has its first name.
fn leaves(tree: &UseTree) -> Vec<Vec<String>> {
    let behind = |first: &syn::Ident, rest: Vec<Vec<String>>| -> Vec<Vec<String>> {
        let first = [first.to_string()];
        rest.into_iter().map(|rest| [&first, &rest[..]].concat()).collect()
    };
    match tree {
        UseTree::Path(path) if path.ident == "crate" => leaves(&path.tree),
        UseTree::Path(path) => behind(&path.ident, leaves(&path.tree)),
        UseTree::Group(group) => group.items.iter().flat_map(leaves).collect(),
        UseTree::Name(name) if name.ident == "self" => vec![Vec::new()],
        UseTree::Name(name) => vec![vec![name.ident.to_string()]],
        UseTree::Rename(name) if name.ident == "hexcast_gpu" => vec![vec![name.ident.to_string()]],
        UseTree::Rename(_) | UseTree::Glob(_) => panic!("a public name that is changed or not named"),
    }
}

/// What a file passes on.
fn passed_on(items: &[Item]) -> Vec<Vec<String>> {
    let of = |item: &Item| match item {
        Item::Use(found) if is_public(&found.vis) && is_listed(&found.attrs) => leaves(&found.tree),
        _ => Vec::new(),
    };
    items.iter().flat_map(of).collect()
}

struct Lister<'a> {
    modules: &'a Modules,
    /// The paths that the root passes on, as [`Modules`] has them.
    passed_on: Vec<Vec<String>>,
    lines: Vec<String>,
}

impl Lister<'_> {
    /// Lists a public module as if it were at `shown`.
    fn module(&mut self, shown: &[String], module: &[String]) {
        for item in &self.modules[module] {
            match item {
                Item::Mod(found) if is_public(&found.vis) && is_listed(&found.attrs) => {
                    let name = [found.ident.to_string()];
                    self.module(&[shown, &name].concat(), &[module, &name].concat());
                }
                Item::Use(found) if is_public(&found.vis) && is_listed(&found.attrs) && !shown.is_empty() => {
                    // another crate's groups are those of the root
                    let is_of_root = |path: &UsePath| ROOTS.iter().any(|root| path.ident == root);
                    let from = match &found.tree {
                        UseTree::Path(path) if is_of_root(path) => &[][..],
                        _ => module,
                    };
                    let named = leaves(&found.tree).into_iter().map(|mut leaf| {
                        leaf.retain(|part| !ROOTS.contains(&part.as_str()));
                        [from, &leaf].concat()
                    });
                    named.for_each(|path| self.name(shown, &path));
                }
                _ => self.item(shown, module, item),
            }
        }
    }

    /// Lists what a `pub use` in `shown` names: an item of a private module as if it were there.
    fn name(&mut self, shown: &[String], named: &[String]) {
        // the root passes on modules
        if shown.is_empty() && self.modules.contains_key(named) && top(named) == named {
            return self.module(&named[named.len() - 1..], named);
        }
        let (name, from) = named.split_last().expect("a path has a name");
        let place = self.shown_place(from);
        let items = self.modules.get(from).filter(|_| place.is_none());
        match items.and_then(|items| items.iter().find(|item| name_of(item).as_ref() == Some(name))) {
            Some(item) => self.item(shown, from, item),
            None => {
                let place = place.unwrap_or_else(|| from[top(from).len() - 1..].to_vec());
                self.say(shown, format!("use {}", [&place[..], std::slice::from_ref(name)].concat().join("::")));
            }
        }
    }

    /// Where callers find a module, if it and all around it are public; the first one, if the root passes it on.
    fn shown_place(&self, module: &[String]) -> Option<Vec<String>> {
        let n_around = top(module).len() - 1;
        let is_public_below = (n_around + 1..module.len()).all(|n| {
            self.modules[&module[..n]].iter().any(
                |item| matches!(item, Item::Mod(m) if m.ident == module[n] && is_public(&m.vis) && is_listed(&m.attrs)),
            )
        });
        let is_passed_on = self.passed_on.iter().any(|of| of == top(module));
        (is_public_below && is_passed_on).then(|| module[n_around..].to_vec())
    }

    fn say(&mut self, shown: &[String], text: String) {
        self.lines.push([&["hexcast".to_string()], shown].concat().join("::") + " " + &text);
    }

    fn item(&mut self, shown: &[String], module: &[String], item: &Item) {
        match item {
            Item::Fn(f) if is_public(&f.vis) && is_listed(&f.attrs) => self.say(shown, text_of(&f.sig)),
            Item::Const(c) if is_public(&c.vis) && is_listed(&c.attrs) => {
                self.say(shown, format!("const {}: {}", c.ident, text_of(&c.ty)));
            }
            Item::Type(t) if is_public(&t.vis) && is_listed(&t.attrs) => {
                self.say(shown, format!("type {} = {}", t.ident, text_of(&t.ty)));
            }
            Item::Struct(s) if is_public(&s.vis) && is_listed(&s.attrs) => {
                self.say(shown, format!("struct {}{}{}", s.ident, text_of(&s.generics), promises(&s.attrs)));
                self.fields(shown, &s.ident.to_string(), &s.fields);
                self.methods(shown, module, &s.ident.to_string());
            }
            Item::Enum(e) if is_public(&e.vis) && is_listed(&e.attrs) => {
                self.say(shown, format!("enum {}{}{}", e.ident, text_of(&e.generics), promises(&e.attrs)));
                for variant in &e.variants {
                    let fields = text_of(&variant.fields);
                    self.say(shown, format!("{}::{}{fields}", e.ident, variant.ident));
                }
                self.methods(shown, module, &e.ident.to_string());
            }
            Item::Trait(t) if is_public(&t.vis) && is_listed(&t.attrs) => {
                self.say(shown, format!("trait {}: {}", t.ident, text_of(&t.supertraits)));
                for inner in &t.items {
                    if let TraitItem::Fn(f) = inner {
                        let has_default = if f.default.is_some() { " {..}" } else { "" };
                        self.say(shown, format!("{}::{}{has_default}", t.ident, text_of(&f.sig)));
                    }
                }
            }
            _ => {}
        }
    }

    fn fields(&mut self, shown: &[String], name: &str, fields: &Fields) {
        for (index, field) in
            fields.iter().enumerate().filter(|(_, field)| is_public(&field.vis) && is_listed(&field.attrs))
        {
            let field_name = field.ident.as_ref().map_or(index.to_string(), ToString::to_string);
            self.say(shown, format!("{name}.{field_name}: {}", text_of(&field.ty)));
        }
    }

    /// Public methods and traits of a type, from all files of its module.
    fn methods(&mut self, shown: &[String], module: &[String], name: &str) {
        let modules = self.modules;
        let of_module = modules
            .iter()
            .filter(|(path, _)| path.is_empty() || top(path) == top(module) || top(path) == path.as_slice());
        for (path, found) in of_module.flat_map(|(path, items)| items.iter().map(move |item| (path, item))) {
            let Item::Impl(found) = found else { continue };
            let Type::Path(own) = &*found.self_ty else { continue };
            let is_own = own.path.segments.last().is_some_and(|segment| segment.ident == name);
            // a type of the same name in another module has its `impl` there
            let defines = |module: &[String]| modules[module].iter().any(|i| name_of(i).as_deref() == Some(name));
            if !is_own || !is_listed(&found.attrs) || path.as_slice() != module && defines(path) {
                continue;
            }
            if top(path) != top(module) && !imports(&modules[path], module, name) {
                continue;
            }
            if let Some((of, _)) = &found.trait_ {
                self.say(shown, format!("impl {} for {name}", text_of(of)));
            }
            for inner in &found.items {
                if let ImplItem::Fn(f) = inner
                    && is_public(&f.vis)
                    && is_listed(&f.attrs)
                {
                    self.say(shown, format!("{name}::{}", text_of(&f.sig)));
                }
            }
        }
    }
}

/// Whether a file imports a type of a module.
fn imports(items: &[Item], module: &[String], name: &str) -> bool {
    let first = top(module).join("::").replace("files::", "");
    items.iter().any(|item| match item {
        Item::Use(found) => {
            let text = text_of(&found.tree);
            text.contains(&format!("::{first}::")) && text.contains(name)
        }
        _ => false,
    })
}

/// The first module of a path: of a group or crate, the module in it.
fn top(module: &[String]) -> &[String] {
    let is_of_one_file = module.first().is_none_or(|first| [GPU, "web"].contains(&first.as_str()));
    &module[..module.len().min(if is_of_one_file { 1 } else { 2 })]
}

fn name_of(item: &Item) -> Option<String> {
    match item {
        Item::Fn(f) => Some(f.sig.ident.to_string()),
        Item::Const(c) => Some(c.ident.to_string()),
        Item::Type(t) => Some(t.ident.to_string()),
        Item::Struct(s) => Some(s.ident.to_string()),
        Item::Enum(e) => Some(e.ident.to_string()),
        Item::Trait(t) => Some(t.ident.to_string()),
        _ => None,
    }
}

fn listed() -> String {
    let mut modules = Modules::new();
    let mut read_crate = |folder: &str, module: &[String]| {
        let folder = root().join(folder);
        read(&folder.join("lib.rs"), &folder, module, &mut modules);
    };
    read_crate("crates/job/src", &[]);
    read_crate("crates/core/src", &[]);
    read_crate("crates/derived/src", &[DERIVED.into()]);
    read_crate("crates/files/src", &[FILES.into()]);
    read_crate("crates/gpu/src", &[GPU.into()]);
    let of_core = passed_on(&modules[&[][..]]);
    let root_of_core = modules.get_mut(&[][..]).expect("the core has a root");
    root_of_core.retain(|item| !matches!(item, Item::Use(_)));
    read(&root().join("src/lib.rs"), &root().join("src"), &[], &mut modules);
    let resolved = |path: Vec<String>| match path[0].as_str() {
        "hexcast_core" => {
            of_core.iter().find(|of| of.last() == path.last()).unwrap_or_else(|| panic!("{path:?}")).clone()
        }
        "hexcast_derived" => [&[DERIVED.into()], &path[1..]].concat(),
        "hexcast_files" => [&[FILES.into()], &path[1..]].concat(),
        "hexcast_gpu" => vec![GPU.into()],
        _ => path,
    };
    let passed_on: Vec<_> = passed_on(&modules[&[][..]]).into_iter().map(resolved).collect();
    let mut lister = Lister { modules: &modules, passed_on: passed_on.clone(), lines: Vec::new() };
    passed_on.iter().for_each(|path| lister.name(&[], path));
    lister.lines.sort();
    lister.lines.dedup();
    lister.lines.join("\n") + "\n"
}

#[test]
fn the_public_api_is_the_one_that_is_listed() {
    let (path, found) = (root().join("docs/api.txt"), listed());
    if std::env::var_os("HEXCAST_BLESS").is_some() {
        assert!(std::env::var_os("CI").is_none(), "CI must not write what it checks");
        std::fs::write(&path, &found).expect("the list can be written");
    }
    let committed = std::fs::read_to_string(&path).expect("docs/api.txt is there");
    let (found, committed): (Vec<&str>, Vec<&str>) = (found.lines().collect(), committed.lines().collect());
    let new: Vec<&&str> = found.iter().filter(|line| !committed.contains(line)).collect();
    let gone: Vec<&&str> = committed.iter().filter(|line| !found.contains(line)).collect();
    assert!(new.is_empty() && gone.is_empty(), "new: {new:#?}\ngone: {gone:#?}");
}

#[test]
fn the_list_has_what_callers_use_and_no_stages() {
    let listed = listed();
    for part in [
        "hexcast::mesher Mesher::fn mesh(&mut self, job: &Job)",
        "hexcast::mesh Mesh::fn fill_box(",
        "hexcast::columns Columns::fn ray(",
        "hexcast::job Job.cells: Option<u32>",
        "hexcast::write enum Format",
        "hexcast::pipeline struct MeshOptions [Clone, Default] [non_exhaustive]",
        "hexcast::gpu Gpu::async fn open(",
    ] {
        assert!(listed.contains(part), "{part} is missing from\n{listed}");
    }
    for part in
        ["Projected", "Params", "KernelText", "hexcast::stages::cast", "hexcast::grid::frame", "hand_out_bands", "pub("]
    {
        assert!(!listed.contains(part), "{part} is public");
    }
}

/// Types with public fields, and enums, that callers may make and take apart whole: what they are does not grow.
const COMPLETE: &[(&str, &str)] = &[
    ("columns BoxRuns", "a layout: offsets and runs, as the kernel `expand` reads them"),
    ("columns CellRun", "a run: its ray, its first cell and its end"),
    ("job Axis", "the three axes"),
    ("job AxisChoice", "the three axes, or the best of them"),
    ("job ByteSize", "a number of bytes"),
    ("job Band", "a value of the job file: a number or a word"),
    ("job Everywhere", "the only word of a band"),
    ("job Level", "a value of the job file: a number or a word"),
    ("job LinesJob", "a list for each of the three axes"),
    ("job Names", "a value of the job file: one name or several"),
    ("job PerAxis", "one value for all three axes, or three"),
    ("job PlaceJob", "a value of the job file: a number or a text"),
    ("job Rule", "the two rules by which a winding number decides; the oracle and the check decide by both"),
    ("job Several", "a list"),
    ("picture Cut", "a plane of cells: its axis and index"),
];

/// What a list of the API says against the rules of its types: each that may grow is `non_exhaustive`, `Mesh` has no public field, and only this
/// crate implements `Store`.
fn breaches(listed: &str, complete: &[(&str, &str)]) -> Vec<String> {
    let lines = || listed.lines().filter_map(|line| line.strip_prefix("hexcast::"));
    let has_fields = |name: &str| lines().any(|line| line.strip_prefix(name).is_some_and(|rest| rest.starts_with('.')));
    let mut found = Vec::new();
    let mut seen = Vec::new();
    for line in lines() {
        let mut words = line.split([' ', '<']);
        let (Some(module), Some(kind), Some(name)) = (words.next(), words.next(), words.next()) else { continue };
        let name = format!("{module} {name}");
        let may_grow = kind == "enum" || kind == "struct" && has_fields(&name);
        if may_grow && !line.contains("[non_exhaustive]") {
            match complete.iter().any(|(of, _)| *of == name) {
                true => seen.push(name),
                false => found.push(format!("{name} is not non_exhaustive")),
            }
        }
    }
    let unseen = complete.iter().filter(|(of, _)| !seen.iter().any(|name| name == of));
    found.extend(unseen.map(|(of, _)| format!("{of} is no such type any more")));
    if has_fields("mesh Mesh") {
        found.push("Mesh has public fields, which could disagree".into());
    }
    if !lines().any(|line| line.starts_with("columns trait Store: ") && line.contains("Sealed")) {
        found.push("Store is not sealed".into());
    }
    for hidden in ["MemoryBudget", "BandLimit"] {
        if listed.contains(hidden) {
            found.push(format!("{hidden} is public, and how memory is divided is not"));
        }
    }
    found
}

#[test]
fn types_that_will_grow_are_non_exhaustive_and_no_fields_can_disagree() {
    let found = breaches(&listed(), COMPLETE);
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn types_that_could_not_grow_are_found() {
    let sealed = "hexcast::columns trait Store: sealed::Sealed + Send + Sync\n";
    let wrong = "hexcast::job struct A\nhexcast::job A.b: u8\nhexcast::job enum B [Debug]\nhexcast::job struct C\n\
                 hexcast::job struct D<T>\nhexcast::job D.0: T\nhexcast::mesh struct Mesh [non_exhaustive]\nhexcast::mesh Mesh.lines: Lines\n";
    let found = breaches(&[sealed, wrong].concat(), &[("job D", "a list"), ("job E", "gone")]);
    let expected = [
        "job A is not non_exhaustive",
        "job B is not non_exhaustive",
        "job E is no such type any more",
        "Mesh has public fields, which could disagree",
    ];
    assert_eq!(found, expected);
    assert_eq!(breaches("hexcast::columns trait Store: Send + Sync\n", &[]), ["Store is not sealed"]);
}
