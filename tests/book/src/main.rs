//! Builds the manual in `docs/` as HTML in `book/`; `deploy/docs.sh` runs it. mdBook and KaTeX are
//! libraries here, so that nothing has to be installed.

use mdbook_driver::MDBook;
use mdbook_driver::errors::Error;
use mdbook_katex::preprocess::KatexProcessor;
use std::fs;
use std::path::{Path, PathBuf};

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
    for page in pages(out)? {
        let html = fs::read_to_string(&page)?;
        let mended = lead_out(&html, &page);
        if mended != html {
            fs::write(&page, mended)?;
        }
    }
    Ok(book)
}

/// Returns the HTML files in a folder and the folders in it.
fn pages(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(pages(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "html") {
            found.push(path);
        }
    }
    Ok(found)
}

/// Returns a page whose links out of the book lead to Markdown files: mdBook makes `.html` of
/// every `.md`, but only pages of the book are HTML files.
fn lead_out(html: &str, page: &Path) -> String {
    let folder = page.parent().unwrap_or(Path::new(""));
    let mut pieces = html.split("href=\"");
    let mut text = pieces.next().unwrap_or_default().to_string();
    for piece in pieces {
        text.push_str("href=\"");
        let (link, rest) = piece.split_at(piece.find('"').unwrap_or(piece.len()));
        let (file, place) = link.split_at(link.find('#').unwrap_or(link.len()));
        match file.strip_suffix(".html").map(|file| format!("{file}.md")) {
            Some(source) if !folder.join(file).exists() && folder.join(&source).exists() => {
                text.push_str(&source);
                text.push_str(place);
            }
            _ => text.push_str(link),
        }
        text.push_str(rest);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use mdbook_driver::book::BookItem;

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

    /// Returns the links and pictures of a page that lead to no file.
    fn dead_links(page: &Path) -> Vec<String> {
        let html = fs::read_to_string(page).unwrap();
        let folder = page.parent().expect("a page is in a folder");
        let mut dead = Vec::new();
        for piece in html.split("href=\"").skip(1).chain(html.split("src=\"").skip(1)) {
            let link = piece.split('"').next().unwrap_or_default();
            let file = link.split('#').next().unwrap_or_default();
            let is_local = !file.is_empty() && !file.contains(':') && !file.starts_with('/');
            if is_local && !folder.join(file).exists() {
                dead.push(format!("{}: {link}", page.display()));
            }
        }
        dead
    }

    /// The book lies next to `docs/`, so that its pages reach the files of the repository.
    #[test]
    fn links_and_pictures_lead_to_files() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let out = tempfile::tempdir_in(&root).unwrap();
        build(&root.join("docs"), out.path()).unwrap_or_else(|e| panic!("{e:#}"));
        // These two gather the text of pages in other folders.
        let is_gathered =
            |page: &PathBuf| page.ends_with("print.html") || page.ends_with("404.html");
        let pages = pages(out.path()).unwrap();
        let dead: Vec<String> = pages
            .iter()
            .filter(|page| !is_gathered(page))
            .flat_map(|page| dead_links(page))
            .collect();
        assert!(dead.is_empty(), "{}", dead.join("\n"));
    }

    #[test]
    fn a_link_to_markdown_outside_the_book_stays_one() {
        let there = tempfile::tempdir().unwrap();
        fs::write(there.path().join("keys.md"), "").unwrap();
        fs::write(there.path().join("page.html"), "").unwrap();
        let page = there.path().join("other.html");
        let html =
            "<a href=\"keys.html#part\">a</a> <a href=\"page.html\">b</a> <a href=\"x.html\">";
        let mended = lead_out(html, &page);
        assert_eq!(mended, html.replace("keys.html", "keys.md"));
        fs::write(&page, mended).unwrap();
        assert_eq!(dead_links(&page), [format!("{}: x.html", page.display())]);
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
