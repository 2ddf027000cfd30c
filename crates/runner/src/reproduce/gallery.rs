//! The gallery: every reproduced table and figure beside what the paper prints, as one HTML file that needs nothing else.

use super::part::{Part, Table, plot_of};
use super::printed::{name, statements};
use crate::failure::Failure;
use crate::output::without_colours;
use crate::plot::canvas::Canvas;
use crate::plot::chart;
use crate::plot::svg::{self, escaped};
use crate::report::{STYLE, filled, reconstructed};
use crate::target::Target;
use crate::version::VERSION;

const PAGE: &str = include_str!("gallery.html");
const OWN_STYLE: &str = include_str!("gallery.css");

/// Width of pictures, pixels: so wide that their text can be read on a telephone.
const CHART_WIDTH: f64 = 400.0;
const SURFACE_WIDTH: f64 = 460.0;

/// A target and what it shows.
pub struct Section {
    pub target: Target,
    pub parts: Vec<Part>,
}

/// The page; the scoreboard comes first.
///
/// # Errors
/// A run whose surface cannot be read.
pub fn page(sections: &[Section]) -> Result<String, Failure> {
    let mut ordered: Vec<&Section> = sections.iter().collect();
    ordered.sort_by_key(|section| section.target != Target::Scoreboard);
    let contents = ordered.iter().map(|section| {
        let target = section.target;
        format!("<li><a href=\"#{}\">{}</a></li>", target.name(), escaped(name(target)))
    });
    let mut all = String::new();
    for section in &ordered {
        all += &html(section)?;
    }
    let parts = [
        ("style", format!("{STYLE}{OWN_STYLE}")),
        ("reconstructed", reconstructed()),
        ("contents", contents.collect()),
        ("version", VERSION.to_owned()),
        ("sections", all),
    ];
    Ok(filled(PAGE, &parts))
}

fn html(section: &Section) -> Result<String, Failure> {
    let target = section.target;
    let mut pictures = String::new();
    let mut rest = String::new();
    let mut words = String::new();
    for part in &section.parts {
        match part {
            Part::Chart(chart) => {
                let text = chart.description();
                pictures += &figure(&chart::figure(&[chart], CHART_WIDTH), "curves", &text, &part.shown());
            }
            Part::Surface { shaded, run } => {
                let text = shaded.lines().next().unwrap_or_default();
                if let Some(canvas) = plot_of(run, SURFACE_WIDTH)? {
                    pictures += &figure(&canvas, "surface", text, shaded);
                }
            }
            Part::Table(table) => {
                rest += &paragraph(&std::mem::take(&mut words));
                rest += &html_table(table);
            }
            Part::Text(text) => words += text,
        }
    }
    rest += &paragraph(&words);
    let mut ours = rest;
    if !pictures.is_empty() {
        ours = format!("<div class=\"pictures\">{pictures}</div>\n{ours}");
    }
    let id = target.name();
    let said: String = statements(target).iter().map(|text| format!("<li>{}</li>", escaped(text))).collect();
    let body = if said.is_empty() {
        ours
    } else {
        format!(
            "<div class=\"beside\"><div class=\"ours\">\n{ours}</div>\n<aside class=\"printed\" aria-label=\"In the paper\">\
             <h3>In the paper</h3><ul>{said}</ul></aside></div>\n"
        )
    };
    let heading = escaped(name(target));
    Ok(format!(
        "<section id=\"{id}\" aria-labelledby=\"{id}-heading\">\n<h2 id=\"{id}-heading\">{heading}</h2>\n{body}</section>\n"
    ))
}

/// Text as the terminal shows it, without its empty lines at both ends.
fn paragraph(text: &str) -> String {
    let text = text.trim_matches('\n');
    if text.is_empty() { String::new() } else { format!("<pre class=\"words\">{}</pre>\n", escaped(text.trim_end())) }
}

/// A picture with its text behind it.
fn figure(canvas: &Canvas, kind: &str, description: &str, text: &str) -> String {
    let svg = svg::element(canvas, &without_colours(description));
    let text = escaped(without_colours(text).trim_matches('\n'));
    format!(
        "<figure class=\"{kind}\">{svg}<details><summary>As text</summary><p>{}</p><pre tabindex=\"0\">{text}</pre></details></figure>\n",
        escaped(&without_colours(description))
    )
}

fn html_table(table: &Table) -> String {
    let class = |(column, text): (usize, &String)| match text.as_str() {
        "MISS" => " class=\"miss\"",
        _ if column >= table.at_terminal => " class=\"words\"",
        _ => "",
    };
    let heading = |of: (usize, &String)| format!("<th scope=\"col\"{}>{}</th>", class(of), escaped(of.1));
    let headings: String = table.headings.iter().enumerate().map(heading).collect();
    let cell = |of: (usize, &String)| format!("<td{}>{}</td>", class(of), escaped(of.1));
    let row = |row: &Vec<String>| format!("<tr>{}</tr>\n", row.iter().enumerate().map(cell).collect::<String>());
    let caption =
        if table.title.is_empty() { String::new() } else { format!("<caption>{}</caption>", escaped(&table.title)) };
    format!(
        "<div class=\"tables\" tabindex=\"0\"><table>{caption}<thead><tr>{headings}</tr></thead>\n<tbody>{}</tbody></table></div>\n",
        table.rows.iter().map(row).collect::<String>()
    )
}
