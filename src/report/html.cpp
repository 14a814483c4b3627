#include "report/html.h"

#include <fmt/format.h>

#include "report/escape.h"

namespace ctn::report {
namespace {

constexpr const char* kStyle = R"css(
:root { color-scheme: light dark; --ink: #1f2328; --muted: #5b646d; --page: #f6f7f8; --card: #ffffff; --line: #dfe3e7;
  --accent: #0072b2; --warn: #b35900; }
@media (prefers-color-scheme: dark) { :root { --ink: #e3e7eb; --muted: #98a2ac; --page: #14171a; --card: #1c2024;
  --line: #31373d; --accent: #5ab4ea; --warn: #f0a040; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink);
  font: 16px/1.55 Inter, "Segoe UI", Roboto, "Helvetica Neue", Arial, "Liberation Sans", sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 40px 24px 64px; }
h1 { font-size: 30px; line-height: 1.2; margin: 0 0 8px; letter-spacing: -0.01em; }
h2 { font-size: 20px; margin: 44px 0 12px; padding-bottom: 6px; border-bottom: 1px solid var(--line); }
p { max-width: 76ch; margin: 12px 0; }
.lead { font-size: 18px; color: var(--muted); margin-top: 0; }
figure, .scroll { background: var(--card); border: 1px solid var(--line); border-radius: 10px; margin: 18px 0; }
figure { padding: 18px 20px 14px; break-inside: avoid; }
figure svg { display: block; width: auto; max-width: 100%; height: auto; margin: 0 auto; }
figcaption { color: var(--muted); font-size: 14px; margin-top: 10px; max-width: 90ch; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 14.5px; font-variant-numeric: tabular-nums; }
caption { caption-side: bottom; text-align: left; color: var(--muted); font-size: 14px; padding: 10px 16px; }
th, td { padding: 8px 16px; text-align: left; }
.number { white-space: nowrap; }
th { font-weight: 600; color: var(--muted); border-bottom: 1px solid var(--line); }
tbody tr + tr td { border-top: 1px solid var(--line); }
.number { text-align: right; }
.note { border-left: 4px solid var(--accent); background: var(--card); border-radius: 0 8px 8px 0; padding: 10px 16px;
  margin: 16px 0; max-width: 90ch; }
.warning { border-left-color: var(--warn); }
dl { display: grid; grid-template-columns: repeat(auto-fill, minmax(190px, 1fr)); gap: 12px; margin: 20px 0; }
dl div { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 10px 14px; }
dt { color: var(--muted); font-size: 13px; }
dd { margin: 2px 0 0; font-size: 17px; font-weight: 600; overflow-wrap: anywhere; }
pre { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 14px 18px; overflow-x: auto;
  font: 13.5px/1.5 ui-monospace, "Cascadia Code", Menlo, Consolas, "Liberation Mono", monospace; }
@media print { body { background: none; } main { padding: 0; } }
)css";

}  // namespace

Page::Page(std::string_view title, std::string_view lead) : title_(escaped(title)) {
  if (!lead.empty()) body_ += fmt::format("<p class=\"lead\">{}</p>\n", escaped(lead));
}

Page& Page::section(std::string_view title, std::string_view id) {
  const std::string name = id.empty() ? "" : fmt::format(" id=\"{}\"", escaped(id));
  body_ += fmt::format("<h2{}>{}</h2>\n", name, escaped(title));
  return *this;
}

Page& Page::element(std::string_view html) {
  body_ += html;
  body_ += '\n';
  return *this;
}

Page& Page::head(std::string_view html) {
  head_ += html;
  head_ += '\n';
  return *this;
}

Page& Page::paragraph(std::string_view text) {
  body_ += fmt::format("<p>{}</p>\n", escaped(text));
  return *this;
}

Page& Page::note(std::string_view text, NoteKind kind) {
  const char* type = kind == NoteKind::kWarning ? "note warning" : "note";
  body_ += fmt::format("<div class=\"{}\">{}</div>\n", type, escaped(text));
  return *this;
}

Page& Page::table(const Table& table) {
  const auto cell = [&](const char* tag, std::size_t column, const std::string& text) {
    return fmt::format("<{}{}>{}</{}>", tag, numeric_column(table, column) ? " class=\"number\"" : "", escaped(text),
                       tag);
  };
  body_ += "<div class=\"scroll\"><table>\n";
  if (!table.caption.empty()) body_ += fmt::format("<caption>{}</caption>\n", escaped(table.caption));
  body_ += "<thead><tr>";
  for (std::size_t i = 0; i < table.header.size(); ++i) body_ += cell("th", i, table.header[i]);
  body_ += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    body_ += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) body_ += cell("td", i, row[i]);
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
  return *this;
}

Page& Page::figure(std::string_view svg, std::string_view caption) {
  body_ += fmt::format("<figure>\n{}\n", svg);
  if (!caption.empty()) body_ += fmt::format("<figcaption>{}</figcaption>\n", escaped(caption));
  body_ += "</figure>\n";
  return *this;
}

Page& Page::facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  body_ += "<dl>\n";
  for (const auto& [name, value] : facts) {
    body_ += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", escaped(name), escaped(value));
  }
  body_ += "</dl>\n";
  return *this;
}

Page& Page::code(std::string_view text) {
  body_ += fmt::format("<pre>{}</pre>\n", escaped(text));
  return *this;
}

std::string Page::html() const {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n<title>{}</title>\n<style>{}</style>\n{}"
      "</head>\n<body>\n<main>\n<h1>{}</h1>\n{}</main>\n</body>\n</html>\n",
      title_, kStyle, head_, title_, body_);
}

}  // namespace ctn::report
