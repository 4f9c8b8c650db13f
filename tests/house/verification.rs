//! The verification manual, `docs/verification.md`: every test named after a closed form, a published number, another program or an order
//! of convergence, with the figures that it holds.
//!
//! Sentences and sources come from the doc comments of the tests, figures from `tests/verification/<file>.txt`, subjects and what is
//! not verified from `tests/verification/contents.toml`. `GEARDYN_RENEW=1 cargo test --test house` writes the page.

mod cases;
mod manual;
mod page;

use std::fs;

use crate::figures;

use manual::manual;
use page::page;

const PAGE: &str = "docs/verification.md";
const CONTENTS: &str = "tests/verification/contents.toml";
const RENEW: &str = "GEARDYN_RENEW=1 cargo test --test house";

/// The page lists the tests that exist, with their sentences and figures.
#[test]
fn keeps_the_manual() {
    let mut manual = manual();
    if figures::renewing() {
        manual.prune();
    }
    let faults = manual.faults();
    assert!(
        faults.is_empty(),
        "the verification manual cannot be made; mend these, then run: {RENEW}\n{}",
        faults.join("\n")
    );
    let text = page(&manual);
    if figures::renewing() {
        fs::write(PAGE, &text).unwrap();
        return;
    }
    let old = fs::read_to_string(PAGE).unwrap_or_default();
    let (old, new): (Vec<&str>, Vec<&str>) = (old.lines().collect(), text.lines().collect());
    let lost: Vec<&&str> = old
        .iter()
        .filter(|line| !new.contains(line))
        .take(5)
        .collect();
    let added: Vec<&&str> = new
        .iter()
        .filter(|line| !old.contains(line))
        .take(5)
        .collect();
    assert!(
        old == new,
        "{PAGE} is out of step with the tests; run: {RENEW}\nonly on the page: {lost:#?}\nonly in the tests: {added:#?}"
    );
}
