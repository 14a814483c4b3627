// Pages as self-contained HTML: one file with its style and figures inside, nothing fetched, no scripts but what the
// caller adds. Light or dark as the reader's system is; prints well.
//
//   report::Page page("Face tracking", "How fast Catan reacts, next to hand-set rates.");
//   page.section("Response time").figure(svg, "Lower is better.").table({{"rate", "mean"}, {{"30 Hz", "52 ms"}}});
//   file << page.html();
//
// All text is escaped here; only what `figure`, `element` and `head` are given is taken as it is.
//
// Thread safety: none; one owner.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/table.h"

namespace ctn::report {

enum class NoteKind { kInfo, kWarning };

class Page {
 public:
  explicit Page(std::string_view title, std::string_view lead = {});

  // Each appends, and returns the page for the next.
  Page& section(std::string_view title, std::string_view id = {});  // `id`: what links to it name
  Page& paragraph(std::string_view text);
  Page& note(std::string_view text, NoteKind kind = NoteKind::kInfo);
  Page& table(const Table& table);
  Page& figure(std::string_view svg, std::string_view caption = {});
  Page& facts(const std::vector<std::pair<std::string, std::string>>& facts);  // name and value, in a row of tiles
  Page& code(std::string_view text);                                           // as written, in fixed width

  Page& element(std::string_view html);  // in the page's body
  Page& head(std::string_view html);     // in its head

  std::string html() const;

 private:
  std::string title_;
  std::string head_;
  std::string body_;
};

}  // namespace ctn::report
