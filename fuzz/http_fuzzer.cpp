// What clients of the page send, and where it listens: whatever it is, what goes on to the HTTP library is a plain
// request of the kinds that are served, no request without the token reaches what can be changed, and what is taken for
// an address, a token or a change can be written and read again.
//
// The first byte says which of the parsers is given the rest.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <variant>

#include "os/linux/tcp.h"
#include "runtime/protocol.h"
#include "web/access.h"
#include "web/change_request.h"
#include "web/metrics.h"
#include "web/request_head.h"

namespace {

using namespace ctn;

constexpr const char* kToken = "0123456789abcdef";

void must(bool holds) {
  if (!holds) std::abort();
}

void try_head(std::string_view text) {
  const auto length = web::head_length(text);
  if (!length) return;
  must(*length <= text.size());
  const auto parsed = web::parse_head(text.substr(0, *length));
  const auto* head = std::get_if<web::RequestHead>(&parsed);
  if (head == nullptr) return must(std::get<web::Refusal>(parsed).status >= 400);
  must(head->content_length <= web::kMaxBody && head->target.size() <= web::kMaxTarget);
  must(head->method == "POST" || head->content_length == 0);
  // What is written anew is one head, which says the same.
  const std::string canonical = web::canonical(*head);
  must(web::head_length(canonical) == canonical.size());
  const auto again = web::parse_head(canonical);
  const auto* same = std::get_if<web::RequestHead>(&again);
  must(same != nullptr && same->method == head->method && same->target == head->target &&
       same->content_length == head->content_length && same->keep_alive == head->keep_alive);

  const bool changes = head->path().starts_with("/control/");
  must(!changes || web::check_access(*head, {.loopback_only = false, .token = std::nullopt}).has_value());
  const auto refusal = web::check_access(*head, {.loopback_only = true, .token = kToken});
  if (!refusal && changes) must(head->authorization == std::string("Bearer ") + kToken);
}

void try_address(std::string_view text) {
  const auto address = os::parse_tcp_address(text);
  if (!address) return must(address.error().kind() == ErrorKind::kCaller);
  must(os::is_numeric_host(address->host));
  const auto again = os::parse_tcp_address(os::to_string(*address));
  must(again.ok() && *again == *address);
}

void try_change(std::string_view text) {
  const auto changes = web::parse_change(text);
  if (!changes) return must(changes.error().kind() == ErrorKind::kCaller);
  const auto again = runtime::parse_request(
      runtime::to_text(runtime::Request{.kind = runtime::Request::Kind::kChange, .changes = *changes}));
  must(again.ok());
}

void try_token(std::string_view text) {
  const auto token = web::token_from(text);
  if (!token) return;
  must(web::same_secret(*token, *token) && !web::same_secret(*token, *token + "x"));
  must(token->find_first_of(" \r\n") == std::string::npos);
}

// Each line is a comment or one sample.
void try_metrics(std::string_view text) {
  const std::string metrics = web::metrics_text(text, text);
  must(metrics.ends_with('\n'));
  std::string_view left = metrics;
  while (!left.empty()) {
    const std::size_t end = left.find('\n');
    const std::string_view line = left.substr(0, end);
    left.remove_prefix(end + 1);
    must(line.starts_with("# HELP catan_") || line.starts_with("# TYPE catan_") || line.starts_with("catan_"));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (static_cast<char>(data[0])) {
    case 'a':
      try_address(text);
      break;
    case 'c':
      try_change(text);
      break;
    case 'm':
      try_metrics(text);
      break;
    case 't':
      try_token(text);
      break;
    default:
      try_head(text);
  }
  return 0;
}
