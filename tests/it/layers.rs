//! Layers: a module uses those of the layers below it and none above, and a crate those below it. Within a module no two
//! modules use each other in a circle.
//!
//! Crates, modules and their order are those of the table in the facade's documentation, section "Layers"; nothing is excepted.
//! What a file uses is read from its tokens, in macros and bodies, too: every path that begins with `crate`, `self`, `super`
//! or a module of its own, whatever it is renamed to. Code for tests may use anything. Uses by method calls alone cannot be
//! found so: a trait of an upper layer for a type of a lower one stands in the upper.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A module, from the crate's root: `["referee", "goal"]`.
type Module = Vec<String>;

/// That a module names something.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
struct Use {
    by: Module,
    file: PathBuf,
    line: usize,
    /// What it names, from the crate's root.
    path: Vec<String>,
}

/// The modules of a crate, and what they name.
#[derive(Default, Debug)]
struct CrateModules {
    modules: BTreeSet<Module>,
    uses: Vec<Use>,
    /// Where what a module imports comes from, by the path under which it can be found there.
    imports: BTreeMap<Vec<String>, Vec<String>>,
    faults: Vec<String>,
}

/// A row of the table of layers: a crate, and its modules from the lowest to the highest.
struct Layer {
    name: String,
    modules: Vec<String>,
}

#[test]
fn no_module_uses_one_above_it_and_no_crate_either() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let layers = layers(&fs::read_to_string(root.join("src/lib.rs")).unwrap());
    let mut faults = Vec::new();
    for (below, layer) in layers.iter().enumerate() {
        let folder = root.join("crates").join(&layer.name);
        faults.extend(CrateModules::of_crate(&folder.join("src/lib.rs")).faults(&layer.modules));
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        let dependencies = manifest.lines().filter(|line| line.starts_with("naoisis_"));
        for dependency in dependencies.filter_map(|line| line.split(['.', ' ', '=']).next()) {
            if !layers[..below].iter().any(|lower| lower.name == dependency) {
                faults.push(format!("`{}` depends on `{dependency}`, which is not below it", layer.name));
            }
        }
    }
    let crates = fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().file_name());
    for name in crates.filter(|name| !layers.iter().any(|layer| *layer.name == **name)) {
        faults.push(format!("the crate {} is not in the table of the documentation", name.display()));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The rows of the table in the documentation: the crate in the first cell, its modules in the second.
fn layers(documentation: &str) -> Vec<Layer> {
    let section = documentation.lines().skip_while(|line| *line != "//! # Layers");
    let words = |cell: &str| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    section
        .skip(1)
        .take_while(|line| !line.starts_with("//! # "))
        .filter_map(|line| {
            let mut cells = line.strip_prefix("//! | ")?.split('|');
            Some(Layer { name: words(cells.next()?).pop()?, modules: words(cells.next()?) })
        })
        .collect()
}

impl CrateModules {
    /// The crate whose root is this file.
    fn of_crate(root: &Path) -> CrateModules {
        let mut modules_of_crate = CrateModules::default();
        modules_of_crate.read(root, root.parent().unwrap(), &mut Vec::new());
        modules_of_crate
    }

    fn read(&mut self, file: &Path, folder: &Path, module: &mut Module) {
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        self.read_text(&text, file, folder, module);
    }

    fn read_text(&mut self, text: &str, file: &Path, folder: &Path, module: &mut Module) {
        let tokens: TokenStream = text.parse().unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        self.modules.insert(module.clone());
        self.walk(&tokens.into_iter().collect::<Vec<_>>(), file, folder, module);
    }

    /// Goes through the tokens of a module, or of something in it.
    fn walk(&mut self, tokens: &[TokenTree], file: &Path, folder: &Path, module: &mut Module) {
        // Modules may be named before they are declared.
        let children: Vec<String> = (0..tokens.len())
            .filter(|&at| is_word(tokens.get(at), "mod") && !is_for_tests(&tokens[..at]))
            .filter_map(|at| word(tokens.get(at + 1)))
            .collect();
        let mut at = 0;
        while at < tokens.len() {
            if let Some(skipped) = item_for_tests(&tokens[at..]) {
                at += skipped;
                continue;
            }
            match &tokens[at] {
                TokenTree::Ident(name) if name == "mod" && word(tokens.get(at + 1)).is_some() => {
                    let name = word(tokens.get(at + 1)).unwrap_or_default();
                    module.push(name.clone());
                    match tokens.get(at + 2) {
                        Some(TokenTree::Group(body)) => {
                            self.modules.insert(module.clone());
                            let body: Vec<TokenTree> = body.stream().into_iter().collect();
                            self.walk(&body, file, &folder.join(&name), module);
                        }
                        _ => {
                            let beside = folder.join(format!("{name}.rs"));
                            let inside = folder.join(&name).join("mod.rs");
                            let child = if beside.exists() { beside } else { inside };
                            self.read(&child, &folder.join(&name), module);
                        }
                    }
                    module.pop();
                    at += 3;
                }
                TokenTree::Ident(name) if name == "use" && !is_punct(tokens.get(at + 1), '<') => {
                    let end = (at..tokens.len()).find(|&end| is_punct(tokens.get(end), ';')).unwrap_or(tokens.len());
                    let line = name.span().start().line;
                    for (path, name) in leaves(&tokens[at + 1..end]) {
                        if let Some(from_root) = self.note(&path, line, file, module, &children) {
                            self.imports.insert([module.clone(), vec![name]].concat(), from_root);
                        }
                    }
                    at = end + 1;
                }
                TokenTree::Ident(name) if is_path(tokens, at) => {
                    let mut path = vec![name.to_string()];
                    let line = name.span().start().line;
                    at += 1;
                    while let (true, Some(next)) = (is_colons(tokens, at), word(tokens.get(at + 2))) {
                        path.push(next);
                        at += 3;
                    }
                    self.note(&path, line, file, module, &children);
                }
                TokenTree::Group(group) => {
                    let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                    self.walk(&inner, file, folder, module);
                    at += 1;
                }
                _ => at += 1,
            }
        }
    }

    /// Notes a path, if it leads into the crate. Returns it from the root.
    fn note(
        &mut self,
        path: &[String],
        line: usize,
        file: &Path,
        module: &Module,
        children: &[String],
    ) -> Option<Vec<String>> {
        let mut from_root: Vec<String> = match path[0].as_str() {
            "crate" => Vec::new(),
            "self" | "super" => module.clone(),
            name if children.iter().any(|child| child == name) => {
                let mut own = module.clone();
                own.push(name.to_owned());
                own
            }
            _ => return None,
        };
        for (index, name) in path.iter().enumerate() {
            match name.as_str() {
                "super" => drop(from_root.pop()),
                "self" | "crate" => {}
                _ if index == 0 => {}
                name => from_root.push(name.to_owned()),
            }
        }
        if from_root.is_empty() || from_root[0] == "*" {
            self.faults.push(format!("{}:{line}: the root is used, which is no module", file.display()));
            return None;
        }
        self.uses.push(Use { by: module.clone(), file: file.to_owned(), line, path: from_root.clone() });
        Some(from_root)
    }

    /// The module in which the thing at the end of a path stands; where a module only has it from another, that one.
    fn home_of(&self, path: &[String]) -> Module {
        let mut path = path.to_vec();
        for _ in 0..8 {
            let depth = (0..=path.len()).rev().find(|&depth| self.modules.contains(&path[..depth])).unwrap_or(0);
            let import = path.get(..=depth).and_then(|imported| self.imports.get(imported));
            match import {
                Some(source) if !path.starts_with(source) => path = [source, &path[depth + 1..]].concat(),
                _ => return path[..depth].to_vec(),
            }
        }
        path
    }

    /// All uses of a module above, and all circles, with files and lines.
    fn faults(&self, order: &[String]) -> Vec<String> {
        let mut faults = self.faults.clone();
        let layer = |module: &str| order.iter().position(|other| other == module);
        for name in order.iter().filter(|name| !self.modules.contains(&vec![(*name).clone()])) {
            faults.push(format!("there is no module `{name}`"));
        }
        for module in self.modules.iter().filter(|module| module.len() == 1 && layer(&module[0]).is_none()) {
            faults.push(format!("the module `{}` is not in the table of the documentation", module[0]));
        }
        // Which modules of one folder use each other, and where.
        let mut arrows: BTreeMap<Module, BTreeMap<(String, String), &Use>> = BTreeMap::new();
        for used in &self.uses {
            let place = format!("{}:{}", used.file.display(), used.line);
            let Some(by) = used.by.first() else {
                faults.push(format!(
                    "{place}: the root passes `{}` on; import it from its own module",
                    used.path.join("::")
                ));
                continue;
            };
            match (layer(by), layer(&used.path[0])) {
                (Some(below), Some(above)) if below < above => {
                    faults.push(format!("{place}: `{by}` uses `{}`, which is above it", used.path[0]));
                }
                (_, None) => faults.push(format!("{place}: there is no module `{}`", used.path[0])),
                _ => {}
            }
            let home = self.home_of(&used.path);
            let common = used.by.iter().zip(&home).take_while(|(one, other)| one == other).count();
            if let (Some(one), Some(other)) = (used.by.get(common), home.get(common)) {
                let folder = arrows.entry(home[..common].to_vec()).or_default();
                folder.entry((one.clone(), other.clone())).or_insert(used);
            }
        }
        // A circle of modules of the root has a use of one above.
        let folders = arrows.iter().filter(|(folder, _)| !folder.is_empty());
        faults.extend(folders.filter_map(|(_, arrows)| circle(arrows)));
        faults
    }
}

/// Describes a circle, if there is one: the uses that are left when modules that use none, or that none uses, are taken away
/// until there are no more of them.
fn circle(arrows: &BTreeMap<(String, String), &Use>) -> Option<String> {
    let mut left = arrows.clone();
    loop {
        let (ones, others): (BTreeSet<String>, BTreeSet<String>) = left.keys().cloned().unzip();
        let before = left.len();
        left.retain(|(one, other), _| others.contains(one) && ones.contains(other));
        if left.len() == before {
            break;
        }
    }
    let lines = left.iter().map(|((one, other), used)| {
        format!("{}:{}: `{one}` uses `{other}`, in a circle", used.file.display(), used.line)
    });
    (!left.is_empty()).then(|| lines.collect::<Vec<_>>().join("\n"))
}

/// The paths that a `use` names, and the names that they get.
fn leaves(tree: &[TokenTree]) -> Vec<(Vec<String>, String)> {
    let mut path = Vec::new();
    let mut at = 0;
    while at < tree.len() {
        match &tree[at] {
            TokenTree::Ident(name) if name == "as" => {
                let name = word(tree.get(at + 1)).unwrap_or_default();
                return vec![(path, name)];
            }
            TokenTree::Ident(name) => path.push(name.to_string()),
            TokenTree::Punct(punct) if punct.as_char() == '*' => path.push("*".to_owned()),
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                let parts = inner.split(|token| is_punct(Some(token), ',')).filter(|part| !part.is_empty());
                return parts.flat_map(leaves).map(|(rest, name)| ([path.clone(), rest].concat(), name)).collect();
            }
            _ => {}
        }
        at += 1;
    }
    let named = path.iter().rev().find(|name| *name != "self").cloned().unwrap_or_default();
    vec![(path, named)]
}

/// How many tokens are an item for tests only, with its attributes, if these tokens begin with one.
fn item_for_tests(tokens: &[TokenTree]) -> Option<usize> {
    let mut at = 0;
    let mut is_for_tests = false;
    while let (true, Some(TokenTree::Group(attribute))) = (is_punct(tokens.get(at), '#'), tokens.get(at + 1)) {
        let text = attribute.stream().to_string().replace(' ', "");
        is_for_tests |= text == "cfg(test)" || text.starts_with("cfg(all(test,") || text == "cfg(doctest)";
        at += 2;
    }
    let ends = |token: &TokenTree| {
        is_punct(Some(token), ';')
            || is_punct(Some(token), ',')
            || matches!(token, TokenTree::Group(body) if body.delimiter() == Delimiter::Brace)
    };
    let length = tokens[at..].iter().position(ends).map_or(tokens.len(), |end| at + end + 1);
    is_for_tests.then_some(length)
}

/// Whether what follows these tokens is for tests only.
fn is_for_tests(before: &[TokenTree]) -> bool {
    let start = (0..before.len()).rev().take_while(|&at| {
        let is_attribute = matches!(&before[at], TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket);
        is_attribute || is_punct(before.get(at), '#') || is_word(before.get(at), "pub") || is_parenthesis(&before[at])
    });
    start.last().is_some_and(|start| {
        let attributes: TokenStream = before[start..].iter().cloned().collect();
        attributes.to_string().replace(' ', "").contains("#[cfg(test)]")
    })
}

fn is_parenthesis(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Parenthesis)
}

/// Whether a path begins here, rather than goes on.
fn is_path(tokens: &[TokenTree], at: usize) -> bool {
    is_colons(tokens, at + 1) && !(at >= 2 && is_colons(tokens, at - 2))
}

fn is_colons(tokens: &[TokenTree], at: usize) -> bool {
    let is_joint = matches!(tokens.get(at), Some(TokenTree::Punct(one)) if one.as_char() == ':' && one.spacing() == Spacing::Joint);
    is_joint && is_punct(tokens.get(at + 1), ':')
}

fn is_punct(token: Option<&TokenTree>, character: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == character)
}

fn is_word(token: Option<&TokenTree>, wanted: &str) -> bool {
    word(token).is_some_and(|word| word == wanted)
}

fn word(token: Option<&TokenTree>) -> Option<String> {
    match token {
        Some(TokenTree::Ident(name)) => Some(name.to_string()),
        _ => None,
    }
}

/// The faults of a small crate: `top` above `middle` above `ground`, with this text in `ground`, of which `ground::deep` is a part.
fn faults_with(text: &str) -> Vec<String> {
    let mut modules_of_crate = CrateModules::default();
    for name in ["top", "middle"] {
        modules_of_crate.modules.insert(vec![name.to_owned()]);
    }
    modules_of_crate.read_text(text, Path::new("ground.rs"), Path::new("no"), &mut vec!["ground".to_owned()]);
    modules_of_crate.faults(&["ground", "middle", "top"].map(str::to_owned))
}

#[test]
fn forbidden_uses_are_found() {
    let forbidden = [
        "use crate::top::Thing;",
        "use crate::{middle::{self, Other}, ground::Own};",
        "use super::middle as harmless;",
        "pub(crate) use super::middle::Thing;",
        "fn body() -> f32 { if true { crate::top::height() } else { 0.0 } }",
        "fn body() { let x = [<crate::top::Thing as Default>::default()]; }",
        "struct Field { thing: Option<super::top::Thing> }",
        "macro_rules! hidden { () => { $crate::top::Thing } }",
        "mod deep { use super::super::top::Thing; }",
        "mod deep { mod deeper { fn f() { super::super::super::top::f(); } } }",
        "#[cfg(feature = \"viewer\")] use crate::top::Thing;",
        "#[cfg(not(test))] use crate::top::Thing;",
        "#[cfg(test)] mod tests { } use crate::top::Thing;",
        "struct Own { #[cfg(test)] tests: u8, thing: crate::top::Thing }",
        "#[cfg(test)] const LENGTH: usize = 1; fn f() { crate::top::f() }",
        "use crate as naoisis;",
        "use super::*;",
        "use crate::Thing;",
        "impl crate::top::Trait for Own {}",
        "#[derive(Default)] #[require(crate::top::Thing)] struct Own;",
        "mod one { use super::two::Thing; } mod two { use super::one::Other; }",
        "mod one { use super::Thing; } mod two { use super::one::Other; } pub use two::Thing;",
        "mod one { use super::Thing; } mod two { use super::one::Other; } use two::Thing as Thing;",
        "mod one { fn f() { super::two::f() } } mod two { mod three { use crate::ground::one; } }",
    ];
    for text in forbidden {
        assert!(!faults_with(text).is_empty(), "{text}");
    }
    let found = faults_with("\n\nuse crate::{\n    ground::Own,\n    top::Thing,\n};");
    assert_eq!(found, ["ground.rs:3: `ground` uses `top`, which is above it"]);
}

#[test]
fn uses_of_modules_below_and_in_tests_are_allowed() {
    let honest = [
        "//! See [`crate::top::Thing`].\n/// And [`crate::middle`].\nfn f() {}",
        "#[cfg(test)]\nmod tests { use crate::top::Thing; }",
        "#[cfg(test)] mod tests;",
        "#[cfg(test)] pub(crate) mod testing;",
        "#[cfg(test)] use crate::top::Thing;",
        "#[cfg(test)] fn f() { crate::top::f() } fn g() {}",
        "const WORDS: &str = \"crate::top::Thing\";",
        "use std::top::Thing; use bevy::{middle, top}; fn f() { top::f(); std::super_top::f() }",
        "pub(in crate::ground) fn f() {} mod deep { pub(in super::super::ground) fn g() { super::f() } }",
        "mod one { pub struct Thing; } mod two { use super::one::Thing; } pub use one::Thing;",
    ];
    for honest in honest {
        assert_eq!(faults_with(honest), [""; 0], "{honest}");
    }
}
