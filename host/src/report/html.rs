//! HTML page in one file, with style, plots and pictures embedded.

use std::fmt::{Arguments, Write};
use std::path::Path;

use anyhow::Context;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::plot::{Plot, escape};
use crate::files::output::write_file;

/// Style sheet. Colours follow the reader's choice of light or dark; wide tables scroll in their own box.
const STYLE: &str = "\
:root{color-scheme:light dark;--paper:#fbfbf9;--card:#fff;--ink:#22252b;--faint:#6a7078;--line:#dcdcd6;\
--good:#14713a;--bad:#a8301f}\
@media(prefers-color-scheme:dark){:root{--paper:#16181c;--card:#1f2228;--ink:#e4e4e0;--faint:#9aa0a8;--line:#3a3e46;\
--good:#6fd093;--bad:#f08a78}}\
*{box-sizing:border-box}\
body{margin:0 auto;padding:1.2rem clamp(.8rem,3vw,2.5rem) 4rem;max-width:1500px;background:var(--paper);\
color:var(--ink);font:16px/1.5 system-ui,sans-serif}\
h1{font-size:1.7rem;line-height:1.2;margin:.4em 0}\
h2{margin:2.2em 0 .4em;padding-top:.5em;border-top:1px solid var(--line);font-size:1.3rem}\
h3{font-size:1rem;margin:.2em 0 .5em}p{max-width:75ch}\
.note{color:var(--faint);font-size:.86rem;overflow-wrap:anywhere}\
.grid{display:grid;gap:1rem;grid-template-columns:repeat(auto-fill,minmax(min(100%,27rem),1fr));margin:1rem 0}\
figure,.card{margin:0;padding:.8rem;background:var(--card);border:1px solid var(--line);border-radius:8px;min-width:0}\
figure img{width:100%;height:auto;display:block;border-radius:4px}\
svg{width:100%;height:auto;display:block}\
svg line{stroke:var(--line)}svg line.zero{stroke:var(--ink)}\
svg text{fill:var(--faint);font-size:11.5px}svg text.label{fill:var(--ink);font-size:12.5px}\
svg polyline{fill:none;stroke-width:2}\
figcaption{font-size:.82rem;line-height:1.7}figcaption span{white-space:nowrap;margin-right:.9em}\
figcaption i{display:inline-block;width:1.6em;vertical-align:middle;margin-right:.35em}\
.scroll{overflow-x:auto;margin:0 0 1rem;background:var(--card);border:1px solid var(--line);border-radius:8px}\
table{border-collapse:collapse;font-size:.86rem;font-variant-numeric:tabular-nums;width:100%}\
h3.caption{margin:1.6em 0 .4em}\
th,td{padding:.28rem .7rem;text-align:right;white-space:nowrap}\
th{font-weight:600;border-bottom:1px solid var(--line);vertical-align:bottom}\
th:first-child,td:first-child{text-align:left;position:sticky;left:0;background:var(--card)}\
tr:nth-child(even) td{background:color-mix(in srgb,var(--line) 22%,var(--card))}\
.good{color:var(--good)}.bad{color:var(--bad)}ul{max-width:75ch;padding-left:1.2em}li{margin:.3em 0}";

/// Page being written.
pub struct Page {
    title: String,
    body: String,
}

impl Page {
    /// Creates a page with its main heading.
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), body: format!("<h1>{}</h1>\n", escape(title)) }
    }

    fn push(&mut self, text: Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(text);
    }

    /// Begins a section.
    pub fn heading(&mut self, text: &str) {
        self.push(format_args!("<h2>{}</h2>\n", escape(text)));
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.push(format_args!("<p>{}</p>\n", escape(text)));
    }

    /// Adds a paragraph in small print.
    pub fn note(&mut self, text: &str) {
        self.push(format_args!("<p class=\"note\">{}</p>\n", escape(text)));
    }

    /// Adds a list of points.
    pub fn list(&mut self, points: impl IntoIterator<Item = String>) {
        self.body += "<ul>";
        for point in points {
            self.push(format_args!("<li>{}</li>", escape(&point)));
        }
        self.body += "</ul>\n";
    }

    /// Adds plots, side by side where there is room.
    pub fn plots(&mut self, plots: &[Plot]) {
        self.body += "<div class=\"grid\">\n";
        for plot in plots {
            self.body += &plot.to_html();
            self.body.push('\n');
        }
        self.body += "</div>\n";
    }

    /// Adds PNG files with captions, side by side where there is room.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn pictures<'p>(
        &mut self,
        pictures: impl IntoIterator<Item = (&'p Path, String)>,
    ) -> anyhow::Result<()> {
        self.body += "<div class=\"grid\">\n";
        for (path, caption) in pictures {
            let png =
                std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
            self.push(format_args!(
                "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
                escape(&caption),
                STANDARD.encode(png)
            ));
        }
        self.body += "</div>\n";
        Ok(())
    }

    /// Adds a table whose first column is text and whose other columns are numbers. A cell that ends in `%` is coloured
    /// as a gain if it begins with `+`, as a loss if it begins with `-`.
    pub fn table(&mut self, caption: &str, headings: &[&str], rows: &[Vec<String>]) {
        self.push(format_args!(
            "<h3 class=\"caption\">{}</h3><div class=\"scroll\"><table><tr>",
            escape(caption)
        ));
        for heading in headings {
            self.push(format_args!("<th>{}</th>", escape(heading)));
        }
        self.body += "</tr>\n";
        for row in rows {
            self.body += "<tr>";
            for cell in row {
                let class = match (cell.chars().next(), cell.ends_with('%')) {
                    (Some('+'), true) => " class=\"good\"",
                    (Some('-'), true) => " class=\"bad\"",
                    _ => "",
                };
                self.push(format_args!("<td{class}>{}</td>", escape(cell)));
            }
            self.body += "</tr>\n";
        }
        self.body += "</table></div>\n";
    }

    /// Writes the page to a file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> anyhow::Result<()> {
        let text = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
             <title>{}</title><style>{STYLE}</style></head>\n<body>\n{}</body></html>\n",
            escape(&self.title),
            self.body
        );
        write_file(path, |file| file.write_all(text.as_bytes()))
    }
}

/// Writes a gain or a loss with its sign, as [`Page::table`] colours it.
pub fn signed_percent(value: f64) -> String {
    // A value that is rounded to 0 gets neither a sign nor a colour.
    if value.abs() < 0.05 { "0.0%".to_owned() } else { format!("{value:+.1}%") }
}
