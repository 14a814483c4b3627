#include "web/answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "web/change_request.h"

namespace ctn::web {
namespace {

const char* reason_of(int status) {
  switch (status) {
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 411:
      return "Length Required";
    case 413:
      return "Payload Too Large";
    case 414:
      return "URI Too Long";
    case 415:
      return "Unsupported Media Type";
    case 417:
      return "Expectation Failed";
    case 431:
      return "Request Header Fields Too Large";
    case 501:
      return "Not Implemented";
    case 503:
      return "Service Unavailable";
    case 505:
      return "HTTP Version Not Supported";
    default:
      return "Error";
  }
}

}  // namespace

std::string answer_of(const Refusal& refusal) {
  const std::string body = error_json(refusal.what, refusal.hint);
  std::string text = fmt::format("HTTP/1.1 {} {}\r\nConnection: close\r\nContent-Type: {}\r\nContent-Length: {}\r\n",
                                 refusal.status, reason_of(refusal.status), kJson, body.size());
  if (refusal.status == 401) text += "WWW-Authenticate: Bearer\r\n";
  if (refusal.status == 405) text += "Allow: GET, HEAD, POST\r\n";
  if (refusal.status == 503) text += "Retry-After: 1\r\n";
  for (const auto& [name, value] : kSafety) text += fmt::format("{}: {}\r\n", name, value);
  return text + "\r\n" + body;
}

std::string event_of(std::string_view name, std::string_view text) {
  std::string event = fmt::format("event: {}\n", name);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > 0) event += fmt::format("data: {}\n", text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return event + "\n";
}

}  // namespace ctn::web
