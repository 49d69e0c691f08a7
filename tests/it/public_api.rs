//! The public API of each crate is the one that is recorded in `tests/public_api`: a change of it is seen in a review.
//!
//! A change that is meant to alter the API writes these files again, in the same commit:
//! `NAOISIS_WRITE_API=1 cargo test --no-default-features --test it public_api`.
//!
//! A file has a line for each item: its path, and its signature, fields, variants or methods, without documentation and bodies.
//! Items of private modules are listed where `pub use` exports them. Macros that generate public types are listed as they are written.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::punctuated::Punctuated;
use syn::{
    Attribute, Fields, ImplItem, Item, ItemEnum, ItemImpl, ItemStruct, ItemTrait, ItemUse, Meta, Token, TraitItem,
    UseTree, Visibility,
};

/// The facade and the crates of the workspace, with the folders of their sources.
fn crates() -> BTreeMap<String, PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let members = root.join("crates").read_dir().unwrap().map(|entry| entry.unwrap());
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let members = members.map(|entry| (name(&entry.path()), entry.path().join("src")));
    members.chain([("naoisis".to_owned(), root.join("src"))]).collect()
}

/// The items of each module of a crate, by the module's path, and which modules can be named from outside.
#[derive(Default)]
struct Modules {
    items: BTreeMap<String, Vec<Item>>,
    public: BTreeSet<String>,
}

impl Modules {
    /// Reads a module and those in it. `folder` holds the files of its modules.
    fn read(&mut self, path: &str, items: Vec<Item>, folder: &Path, is_public: bool) {
        for item in &items {
            let Item::Mod(module) = item else { continue };
            if is_hidden(&module.attrs) {
                continue;
            }
            let name = module.ident.to_string();
            let (below, folder_below) = (format!("{path}::{name}"), folder.join(&name));
            let is_public = is_public && is_pub(&module.vis);
            if let Some((_, items)) = &module.content {
                self.read(&below, items.clone(), &folder_below, is_public);
                continue;
            }
            let file = [folder.join(format!("{name}.rs")), folder_below.join("mod.rs")];
            let file = file.into_iter().find(|file| file.exists()).unwrap_or_else(|| panic!("no file of {below}"));
            let file = syn::parse_file(&std::fs::read_to_string(file).unwrap()).unwrap();
            self.read(&below, file.items, &folder_below, is_public);
        }
        if is_public {
            self.public.insert(path.to_owned());
        }
        self.items.insert(path.to_owned(), items);
    }

    /// The lines of a crate, sorted.
    fn lines(&self) -> BTreeSet<String> {
        let mut lines = BTreeSet::new();
        for path in &self.public {
            lines.insert(format!("mod {path}"));
            self.list_macros(path, &mut lines);
            for item in self.items[path].iter().filter(|item| !matches!(item, Item::Mod(_))) {
                match item {
                    Item::Use(exported) if is_pub(&exported.vis) => self.export(path, exported, &mut lines),
                    item => Self::list(path, item, None, &mut lines),
                }
            }
        }
        let is_letter = |letter: char| letter.is_alphanumeric() || letter == '_';
        let listed: BTreeSet<String> =
            lines.iter().flat_map(|line| line.split(|letter| !is_letter(letter))).map(str::to_owned).collect();
        let declared: BTreeSet<String> = self.items.values().flatten().filter_map(name_of).collect();
        // Types that are declared here and listed nowhere are private.
        let is_private = |item: &ItemImpl| {
            let own_name = match &*item.self_ty {
                syn::Type::Path(path) => path.path.segments.last().map(|last| last.ident.to_string()),
                _ => None,
            };
            own_name.is_some_and(|name| declared.contains(&name) && !listed.contains(&name))
        };
        for (path, items) in &self.items {
            for item in items {
                if let Item::Impl(item) = item
                    && !is_hidden(&item.attrs)
                    && !is_private(item)
                {
                    of_impl(path, item, &mut lines);
                }
            }
        }
        lines
    }

    /// Lists what `pub use` exports: an item of a private module of this crate as if it were here, and else the path.
    fn export(&self, path: &str, exported: &ItemUse, lines: &mut BTreeSet<String>) {
        for (target, name) in names_of(&exported.tree) {
            let target = target.strip_prefix("crate::").map_or_else(
                || format!("{path}::{}", target.trim_start_matches("self::")),
                |rest| format!("{}::{rest}", path.split("::").next().unwrap()),
            );
            let (module, item) = target.rsplit_once("::").unwrap();
            let found = self.items.get(module).filter(|_| !self.public.contains(module));
            let found =
                found.and_then(|items| items.iter().find(|found| name_of(found).is_some_and(|name| name == item)));
            match found {
                Some(found) => Self::list(path, found, Some(&name), lines),
                None => {
                    lines.insert(format!("{path}: use {}", squeezed(exported.tree.to_token_stream())));
                    self.list_macros(module, lines);
                }
            }
        }
    }

    /// Adds the macros of a module of this crate in which macros make types.
    fn list_macros(&self, path: &str, lines: &mut BTreeSet<String>) {
        let macros = || {
            let items = self.items.get(path).into_iter().flatten();
            items.filter_map(|item| if let Item::Macro(item) = item { Some(item) } else { None })
        };
        let makes_types = |tokens: String| ["pub struct", "pub enum"].iter().any(|made| tokens.contains(made));
        if macros().any(|item| makes_types(item.mac.tokens.to_string())) {
            for item in macros().filter(|item| !is_hidden(&item.attrs)) {
                let (called, name) = (&item.mac.path, item.ident.as_ref());
                let tokens = squeezed(undocumented(item.mac.tokens.clone()));
                lines.insert(format!("{path}: {}! {{ {tokens} }}", squeezed(quote!(#called #name))));
            }
        }
    }

    /// Adds the line of an item of the module at `path`, under another name if it is exported by one. Implementations have lines of their own.
    fn list(path: &str, item: &Item, name: Option<&str>, lines: &mut BTreeSet<String>) {
        let mut add = |name: &str, tokens: TokenStream| lines.insert(format!("{path}::{name}: {}", squeezed(tokens)));
        let own = name_of(item).unwrap_or_default();
        let name = name.unwrap_or(&own);
        match item {
            Item::Fn(item) if is_api(&item.vis, &item.attrs) => drop(add(name, item.sig.to_token_stream())),
            Item::Const(item) if is_api(&item.vis, &item.attrs) => {
                let kind = &item.ty;
                add(name, quote!(const: #kind));
            }
            Item::Static(item) if is_api(&item.vis, &item.attrs) => {
                let kind = &item.ty;
                add(name, quote!(static: #kind));
            }
            Item::Type(item) if is_api(&item.vis, &item.attrs) => {
                let (generics, kind) = (&item.generics, &item.ty);
                add(name, quote!(type #generics = #kind));
            }
            Item::Struct(item) if is_api(&item.vis, &item.attrs) => drop(add(name, of_struct(item))),
            Item::Enum(item) if is_api(&item.vis, &item.attrs) => drop(add(name, of_enum(item))),
            Item::Trait(item) if is_api(&item.vis, &item.attrs) => drop(add(name, of_trait(item))),
            _ => {}
        }
    }
}

/// The tokens without documentation.
fn undocumented(tokens: TokenStream) -> TokenStream {
    let mut kept = Vec::new();
    for token in tokens {
        match token {
            TokenTree::Group(group) if is_documentation(&group) => drop(kept.pop()),
            TokenTree::Group(group) => {
                kept.push(Group::new(group.delimiter(), undocumented(group.stream())).into());
            }
            token => kept.push(token),
        }
    }
    kept.into_iter().collect()
}

/// Whether a group is `[doc = ...]`, after the `#` of an attribute.
fn is_documentation(group: &Group) -> bool {
    let first = group.stream().into_iter().next();
    group.delimiter() == Delimiter::Bracket && first.is_some_and(|token| token.to_string() == "doc")
}

fn is_pub(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn is_api(visibility: &Visibility, attributes: &[Attribute]) -> bool {
    is_pub(visibility) && !is_hidden(attributes)
}

/// Whether an item is for tests only, or is not documented.
fn is_hidden(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) if list.path.is_ident("cfg") => ["test", "doctest"].contains(&&*list.tokens.to_string()),
        Meta::List(list) if list.path.is_ident("doc") => list.tokens.to_string() == "hidden",
        _ => false,
    })
}

fn name_of(item: &Item) -> Option<String> {
    Some(match item {
        Item::Fn(item) => item.sig.ident.to_string(),
        Item::Const(item) => item.ident.to_string(),
        Item::Static(item) => item.ident.to_string(),
        Item::Type(item) => item.ident.to_string(),
        Item::Struct(item) => item.ident.to_string(),
        Item::Enum(item) => item.ident.to_string(),
        Item::Trait(item) => item.ident.to_string(),
        _ => return None,
    })
}

/// The paths that a `use` names, each with the name that it has from then on.
fn names_of(tree: &UseTree) -> Vec<(String, String)> {
    match tree {
        UseTree::Path(path) => {
            let below = names_of(&path.tree).into_iter();
            below.map(|(rest, name)| (format!("{}::{rest}", path.ident), name)).collect()
        }
        UseTree::Name(name) => vec![(name.ident.to_string(), name.ident.to_string())],
        UseTree::Rename(rename) => vec![(rename.ident.to_string(), rename.rename.to_string())],
        UseTree::Glob(_) => vec![("*".to_owned(), "*".to_owned())],
        UseTree::Group(group) => group.items.iter().flat_map(names_of).collect(),
    }
}

/// Attributes that are part of the API: what a type derives, whether it may grow.
fn attributes_of(attributes: &[Attribute]) -> TokenStream {
    let derived = attributes.iter().filter(|attribute| attribute.path().is_ident("derive"));
    let derived = derived
        .flat_map(|attribute| attribute.parse_args_with(Punctuated::<syn::Path, Token![,]>::parse_terminated).unwrap());
    let mut names: Vec<String> = derived.map(|path| squeezed(path.to_token_stream())).collect();
    names.sort();
    let grows = attributes.iter().any(|attribute| attribute.path().is_ident("non_exhaustive"));
    let grows = grows.then(|| quote!(#[non_exhaustive]));
    let names: Vec<TokenStream> = names.iter().map(|name| name.parse().unwrap()).collect();
    let derived = (!names.is_empty()).then(|| quote!(#[derive(#(#names),*)]));
    quote!(#grows #derived)
}

/// The public fields of a struct, or all of a variant; `..` stands for those that are private.
fn fields_of(fields: &Fields, are_public: bool) -> TokenStream {
    let is_shown = |field: &&syn::Field| are_public || is_pub(&field.vis);
    let shown = fields.iter().filter(is_shown).map(|field| {
        let (name, kind) = (field.ident.as_ref().map(|name| quote!(#name:)), &field.ty);
        quote!(#name #kind)
    });
    let rest = (!fields.iter().all(|field| is_shown(&field))).then(|| quote!(..));
    match fields {
        Fields::Named(_) => quote!({ #(#shown),* #rest }),
        Fields::Unnamed(_) => quote!((#(#shown),* #rest)),
        Fields::Unit => TokenStream::new(),
    }
}

fn of_struct(item: &ItemStruct) -> TokenStream {
    let (attributes, generics, fields) = (attributes_of(&item.attrs), &item.generics, fields_of(&item.fields, false));
    quote!(#attributes struct #generics #fields)
}

fn of_enum(item: &ItemEnum) -> TokenStream {
    let variants = item.variants.iter().map(|variant| {
        let (name, fields) = (&variant.ident, fields_of(&variant.fields, true));
        quote!(#name #fields)
    });
    let (attributes, generics) = (attributes_of(&item.attrs), &item.generics);
    quote!(#attributes enum #generics { #(#variants),* })
}

fn of_trait(item: &ItemTrait) -> TokenStream {
    let items = item.items.iter().map(|item| match item {
        TraitItem::Fn(function) => {
            let (signature, provided) = (&function.sig, function.default.as_ref().map(|_| quote!({ .. })));
            quote!(#signature #provided;)
        }
        TraitItem::Type(kind) => {
            let (name, bounds) = (&kind.ident, &kind.bounds);
            quote!(type #name: #bounds;)
        }
        TraitItem::Const(constant) => {
            let (name, kind) = (&constant.ident, &constant.ty);
            quote!(const #name: #kind;)
        }
        _ => TokenStream::new(),
    });
    let (generics, supertraits) = (&item.generics, &item.supertraits);
    let supertraits = (!supertraits.is_empty()).then(|| quote!(: #supertraits));
    quote!(trait #generics #supertraits { #(#items)* })
}

/// Adds the public functions and constants of a type, or that it has a trait.
fn of_impl(module: &str, item: &ItemImpl, lines: &mut BTreeSet<String>) {
    let kind = squeezed(item.self_ty.to_token_stream());
    if let Some((_, implemented, _)) = &item.trait_ {
        let (generics, condition) = (&item.generics, &item.generics.where_clause);
        lines.insert(format!("{module}::{kind}: {}", squeezed(quote!(impl #generics #implemented #condition))));
        return;
    }
    for item in &item.items {
        match item {
            ImplItem::Fn(function) if is_api(&function.vis, &function.attrs) => {
                let (name, signature) = (&function.sig.ident, squeezed(function.sig.to_token_stream()));
                lines.insert(format!("{module}::{kind}::{name}: {signature}"));
            }
            ImplItem::Const(constant) if is_api(&constant.vis, &constant.attrs) => {
                let (name, kind_of_it) = (&constant.ident, squeezed(constant.ty.to_token_stream()));
                lines.insert(format!("{module}::{kind}::{name}: const: {kind_of_it}"));
            }
            _ => {}
        }
    }
}

/// Tokens as text, with fewer spaces than they are printed with.
fn squeezed(tokens: TokenStream) -> String {
    let mut text = tokens.to_string();
    for (spaced, tight) in [
        (" :: ", "::"),
        (":: ", "::"),
        (" ::", "::"),
        (" : ", ": "),
        (" , ", ", "),
        (" ,", ","),
        (" ;", ";"),
        ("& ", "&"),
        (" < ", "<"),
        (" <", "<"),
        ("< ", "<"),
        (" >", ">"),
        ("-> ", "-> "),
        (" (", "("),
        ("( ", "("),
        (" )", ")"),
        ("# [", "#["),
        ("' ", "'"),
    ] {
        text = text.replace(spaced, tight);
    }
    text.replace("->", " -> ").replace("  ", " ")
}

#[test]
fn the_public_api_is_the_recorded_one() {
    let mut changed = String::new();
    for (name, sources) in crates() {
        let root = syn::parse_file(&std::fs::read_to_string(sources.join("lib.rs")).unwrap()).unwrap();
        let mut modules = Modules::default();
        modules.read(&name, root.items, &sources, true);
        let now = modules.lines();
        assert!(now.len() > 5, "{name}: {now:?}");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/public_api/{name}.txt"));
        if std::env::var_os("NAOISIS_WRITE_API").is_some() {
            let text: String = now.iter().map(|line| format!("{line}\n")).collect();
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, text).unwrap();
            continue;
        }
        let recorded = std::fs::read_to_string(&path).unwrap_or_default();
        let recorded: BTreeSet<String> = recorded.lines().map(str::to_owned).collect();
        for line in recorded.difference(&now) {
            changed += &format!("- {line}\n");
        }
        for line in now.difference(&recorded) {
            changed += &format!("+ {line}\n");
        }
    }
    assert!(
        changed.is_empty(),
        "the public API is not the recorded one. If that is meant, write tests/public_api again, as tests/it/public_api.rs \
         says:\n{changed}"
    );
}
