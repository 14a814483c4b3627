// The head of a request, parsed before any other code sees it. Clients may be hostile: what is not plainly a request of
// the few kinds that are served is refused here. The HTTP library gets a request that is written anew (canonical()),
// with the headers that are used and no others. So encodings, ranges, multipart bodies and headers that could be read
// in two ways never reach it.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace ctn::web {

constexpr std::size_t kMaxHead = 16 * 1024;  // bytes, the empty line included
constexpr std::size_t kMaxHeaders = 64;      // lines
constexpr std::size_t kMaxTarget = 1024;     // bytes
constexpr std::size_t kMaxBody = 64 * 1024;  // bytes

// Why a request is not served.
struct Refusal {
  int status = 400;
  std::string what;
  std::string hint;
  friend bool operator==(const Refusal&, const Refusal&) = default;
};

struct RequestHead {
  std::string method;  // GET, HEAD, POST
  std::string target;  // "/live?x=1": begins with '/', printable ASCII
  std::optional<std::string> host{};
  std::optional<std::string> origin{};
  std::optional<std::string> authorization{};
  std::size_t content_length = 0;  // at most kMaxBody; 0 unless POST
  bool keep_alive = true;          // as the client wants it
  bool expects_continue = false;   // the client waits for 100 Continue before it sends the body

  // The target without its query.
  std::string_view path() const { return std::string_view(target).substr(0, target.find('?')); }
};

// The length of the head that `text` begins with, including the empty line that ends it; nothing: it has not ended yet.
std::optional<std::size_t> head_length(std::string_view text);

// `text`: as long as head_length() says.
std::variant<RequestHead, Refusal> parse_head(std::string_view text);

// The same request, as the HTTP library gets it.
std::string canonical(const RequestHead& head);

}  // namespace ctn::web
