//! Builds the manual in `docs/` as HTML in `book/`; `deploy/docs.sh` runs it. mdBook and KaTeX are
//! libraries here, so that nothing has to be installed.

use mdbook_driver::MDBook;
use mdbook_driver::errors::Error;
use mdbook_katex::preprocess::KatexProcessor;
use std::path::Path;

fn main() -> Result<(), Error> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    build(&root.join("docs"), &root.join("book"))?;
    println!("The manual is in book/index.html");
    Ok(())
}

/// Builds the book in the folder `docs` into the folder `out`.
fn build(docs: &Path, out: &Path) -> Result<MDBook, Error> {
    let mut book = MDBook::load(docs)?;
    book.config.build.build_dir = out.into();
    // Replaces the program `mdbook-katex`, which the configuration of the book names.
    book.with_preprocessor(KatexProcessor);
    book.build()?;
    Ok(book)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mdbook_driver::book::BookItem;
    use std::fs;

    /// Returns the text of a page between its tags, without code, scripts and MathML.
    fn words(html: &str) -> String {
        let mut text = html.to_string();
        for tag in ["script", "style", "pre", "code", "math"] {
            let close = format!("</{tag}>");
            while let Some(start) = [format!("<{tag}>"), format!("<{tag} ")]
                .iter()
                .filter_map(|open| text.find(open))
                .min()
            {
                let length = text[start..].find(&close).expect("a closed tag") + close.len();
                text.replace_range(start..start + length, "");
            }
        }
        text
    }

    /// Returns the formulas that KaTeX did not understand: it leaves them in their dollar signs.
    fn is_rendered(html: &str) -> bool {
        !words(html).contains('$')
    }

    #[test]
    fn every_chapter_is_a_page_with_its_formulas() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
        let out = tempfile::tempdir().unwrap();
        let book = build(&docs, out.path()).unwrap_or_else(|e| panic!("{e:#}"));
        let (mut pages, mut formulas) = (0, 0);
        for item in book.iter() {
            let BookItem::Chapter(chapter) = item else { continue };
            let path = chapter.path.as_ref().expect("a chapter with a file").with_extension("html");
            let html = fs::read_to_string(out.path().join(&path))
                .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            assert!(html.contains(&format!("{} - Crumple</title>", chapter.name)), "{path:?}");
            assert!(is_rendered(&html), "{path:?} has a formula that KaTeX does not understand");
            pages += 1;
            formulas += html.matches("<math").count();
        }
        assert!(pages > 20 && formulas > 100, "{pages} pages, {formulas} formulas");
    }

    #[test]
    fn a_broken_formula_is_found() {
        let there = tempfile::tempdir().unwrap();
        let docs = there.path().join("docs");
        fs::create_dir(&docs).unwrap();
        let manual = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
        fs::copy(manual.join("book.toml"), docs.join("book.toml")).unwrap();
        fs::write(docs.join("SUMMARY.md"), "- [A](a.md)\n- [B](b.md)\n").unwrap();
        fs::write(docs.join("a.md"), "# A\n$x^2$ and `$HOME`\n").unwrap();
        fs::write(docs.join("b.md"), "# B\n$\\frac{1$\n").unwrap();
        let out = there.path().join("book");
        build(&docs, &out).unwrap_or_else(|e| panic!("{e:#}"));
        let rendered = |page: &str| is_rendered(&fs::read_to_string(out.join(page)).unwrap());
        assert!(rendered("a.html") && !rendered("b.html"));
    }
}
