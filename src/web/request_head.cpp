#include "web/request_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <system_error>

#include "base/text.h"

namespace ctn::web {
namespace {

constexpr std::string_view kEndOfLine = "\r\n";

Refusal bad(std::string what) { return {400, std::move(what), "send a request as HTTP/1.1 has it"}; }

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same_word(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

bool is_token(std::string_view text) {
  constexpr std::string_view kMarks = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    return (lower(c) >= 'a' && lower(c) <= 'z') || (c >= '0' && c <= '9') || kMarks.find(c) != std::string_view::npos;
  });
}

bool is_printable_ascii(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~'; });
}

bool is_header_value(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte == '\t' || (byte >= ' ' && byte != 0x7F);
  });
}

// Whether the word is in a list such as that of the header Connection.
bool lists(std::string_view list, std::string_view word) {
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    if (same_word(trimmed(list.substr(0, comma)), word)) return true;
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return false;
}

// The next line without its line end; nothing: there is no complete line.
std::optional<std::string_view> next_line(std::string_view& text) {
  const std::size_t end = text.find(kEndOfLine);
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end + kEndOfLine.size());
  return line;
}

std::optional<Refusal> read_request_line(std::string_view line, RequestHead& head) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) return bad("the first line is no request");
  const std::string_view method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (!is_token(method)) return bad("the first line is no request");
  if (version != "HTTP/1.1" && version != "HTTP/1.0") {
    return Refusal{505, "only HTTP/1.1 is spoken here", "use a client that speaks it"};
  }
  if (target.size() > kMaxTarget) return Refusal{414, "the address is too long", "shorten it"};
  if (target.empty() || target.front() != '/' || !is_printable_ascii(target)) {
    return bad("the first line names no path");
  }
  if (method != "GET" && method != "HEAD" && method != "POST") {
    return Refusal{405, fmt::format("the method {} is not served", printable(method.substr(0, 32))), "use GET or POST"};
  }
  head.method = method;
  head.target = target;
  head.keep_alive = version == "HTTP/1.1";
  return std::nullopt;
}

std::optional<Refusal> read_length(std::string_view value, std::size_t& length) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool all = end == value.data() + value.size() && !value.empty();
  if (!all || error == std::errc::invalid_argument) return bad("Content-Length is no number");
  if (error == std::errc::result_out_of_range || number > kMaxBody) {
    return Refusal{413, fmt::format("the body is longer than {} bytes", kMaxBody), "send less"};
  }
  length = static_cast<std::size_t>(number);
  return std::nullopt;
}

// Keeps the value of a header that must not come twice.
std::optional<Refusal> keep(std::optional<std::string>& place, std::string_view name, std::string_view value) {
  if (place) return bad(fmt::format("{} comes twice", name));
  place = value;
  return std::nullopt;
}

struct Seen {
  bool length = false;
  bool connection = false;
};

std::optional<Refusal> read_header(std::string_view name, std::string_view value, RequestHead& head, Seen& seen) {
  if (same_word(name, "Host")) return keep(head.host, "Host", value);
  if (same_word(name, "Origin")) return keep(head.origin, "Origin", value);
  if (same_word(name, "Authorization")) return keep(head.authorization, "Authorization", value);
  if (same_word(name, "Content-Length")) {
    if (seen.length) return bad("Content-Length comes twice");
    seen.length = true;
    return read_length(value, head.content_length);
  }
  if (same_word(name, "Transfer-Encoding")) {
    return Refusal{501, "bodies in chunks are not taken", "send the body whole, with its Content-Length"};
  }
  if (same_word(name, "Content-Encoding") && !same_word(value, "identity")) {
    return Refusal{415, "encoded bodies are not taken", "send the body as it is"};
  }
  if (same_word(name, "Connection")) {
    if (lists(value, "close")) head.keep_alive = false;
    if (lists(value, "keep-alive") && !seen.connection) head.keep_alive = true;
    seen.connection = seen.connection || lists(value, "close");
  }
  if (same_word(name, "Expect")) {
    if (!same_word(value, "100-continue")) return Refusal{417, "this cannot be expected", "leave Expect out"};
    head.expects_continue = true;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::size_t> head_length(std::string_view text) {
  constexpr std::string_view kEnd = "\r\n\r\n";
  const std::size_t end = text.find(kEnd);
  if (end == std::string_view::npos) return std::nullopt;
  return end + kEnd.size();
}

std::variant<RequestHead, Refusal> parse_head(std::string_view text) {
  RequestHead head;
  Seen seen;
  const auto first = next_line(text);
  if (!first) return bad("the first line is no request");
  if (auto refusal = read_request_line(*first, head)) return *refusal;
  std::size_t count = 0;
  while (true) {
    const auto line = next_line(text);
    if (!line) return bad("the head does not end");
    if (line->empty()) break;
    if (++count > kMaxHeaders) return Refusal{431, "there are too many headers", "send fewer"};
    const std::size_t colon = line->find(':');
    if (colon == std::string_view::npos) return bad("a header has no colon");
    const std::string_view name = line->substr(0, colon);
    const std::string_view value = line->substr(colon + 1);
    if (!is_token(name) || !is_header_value(value)) return bad("a header has characters that it may not have");
    if (auto refusal = read_header(name, trimmed(value), head, seen)) return *refusal;
  }
  if (head.method == "POST" && !seen.length) {
    return Refusal{411, "a body without Content-Length is not taken", "send its length"};
  }
  if (head.method != "POST" && head.content_length > 0) return bad(head.method + " has no body");
  if (head.content_length == 0) head.expects_continue = false;
  return head;
}

std::string canonical(const RequestHead& head) {
  std::string text = fmt::format("{} {} HTTP/1.1\r\n", head.method, head.target);
  if (head.method == "POST") {
    text += fmt::format("Content-Type: application/json\r\nContent-Length: {}\r\n", head.content_length);
  }
  if (!head.keep_alive) text += "Connection: close\r\n";
  return text + "\r\n";
}

}  // namespace ctn::web
