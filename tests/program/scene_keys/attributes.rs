//! Reads the attributes of an item: how serde reads the item, and its documentation.

use std::collections::BTreeMap;

use syn::Attribute;

/// Whether serde reads a type as it stands. Numbers and vectors are converted from others.
pub fn is_read(attributes: &[Attribute]) -> bool {
    let derives = |attribute: &Attribute| {
        let mut is_read = false;
        let parsed = attribute.parse_nested_meta(|meta| {
            is_read |= meta.path.segments.last().unwrap().ident == "Deserialize";
            Ok(())
        });
        attribute.path().is_ident("derive") && parsed.is_ok() && is_read
    };
    attributes.iter().any(derives) && !serde(attributes).contains_key("try_from")
}

/// The serde attributes of an item, each with its values.
pub fn serde(attributes: &[Attribute]) -> BTreeMap<String, Vec<String>> {
    let mut found = BTreeMap::<String, Vec<String>>::new();
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("serde")) {
        let parsed = attribute.parse_nested_meta(|meta| {
            let values = found.entry(meta.path.require_ident()?.to_string()).or_default();
            if meta.input.peek(syn::Token![=]) {
                values.push(meta.value()?.parse::<syn::LitStr>()?.value());
            }
            Ok(())
        });
        parsed.unwrap();
    }
    found
}

/// The documentation of an item on one line.
pub fn doc(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        syn::Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) => Some(text.value().trim().to_owned()),
            _ => None,
        },
        _ => None,
    });
    lines.collect::<Vec<_>>().join(" ")
}
