#include "web/access.h"

#include <algorithm>
#include <cstddef>

#include "base/text.h"
#include "os/linux/tcp.h"

namespace ctn::web {
namespace {

constexpr std::string_view kControl = "/control/";
constexpr std::string_view kWhatIf = "/whatif";

bool names_this_machine(std::string_view host) {
  std::string name(host);
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return name == "localhost" || os::is_loopback_host(name);
}

bool is_of_another_site(const RequestHead& head) { return head.origin && *head.origin != "http://" + *head.host; }

std::optional<Refusal> check_control(const RequestHead& head, const AccessRules& rules) {
  if (!rules.token) {
    return Refusal{403, "this server only shows; it changes nothing", "start it with --allow-control"};
  }
  if (is_of_another_site(head)) {
    return Refusal{403, "a page of another site may not change anything", "use the page of this server"};
  }
  constexpr std::string_view kScheme = "Bearer ";
  const std::string_view given = head.authorization ? std::string_view(*head.authorization) : std::string_view();
  if (!given.starts_with(kScheme) || !same_secret(given.substr(kScheme.size()), *rules.token)) {
    return Refusal{401, "the token is missing, or another",
                   "send the header 'Authorization: Bearer TOKEN' with the token that the server printed"};
  }
  return std::nullopt;
}

}  // namespace

std::string_view host_of(std::string_view authority) {
  if (authority.starts_with('[')) {
    const std::size_t end = authority.find(']');
    if (end == std::string_view::npos) return {};
    const std::string_view rest = authority.substr(end + 1);
    return rest.empty() || rest.front() == ':' ? authority.substr(1, end - 1) : std::string_view();
  }
  const std::size_t colon = authority.find(':');
  if (colon != std::string_view::npos && authority.find(':', colon + 1) != std::string_view::npos) return {};
  return authority.substr(0, colon);
}

bool same_secret(std::string_view a, std::string_view b) {
  unsigned differences = a.size() == b.size() ? 0U : 1U;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const char other = b.empty() ? '\0' : b[i % b.size()];
    differences |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(other);
  }
  return differences == 0;
}

Result<std::string> token_from(std::string_view text) {
  constexpr std::size_t kMin = 16;
  constexpr std::size_t kMax = 256;
  const std::string_view token = trimmed(text);
  const bool plain = std::all_of(token.begin(), token.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (token.size() >= kMin && token.size() <= kMax && plain) return std::string(token);
  return Error::caller("the token is not 16 to 256 printable characters without blanks",
                       "make one with `openssl rand -hex 16`");
}

std::optional<Refusal> check_access(const RequestHead& head, const AccessRules& rules) {
  if (!head.host) return Refusal{400, "the request names no host", "send a request as HTTP/1.1 has it"};
  if (rules.loopback_only && !names_this_machine(host_of(*head.host))) {
    return Refusal{403, "this server answers only to names of this machine",
                   "name it localhost or 127.0.0.1, or let it listen at another address"};
  }
  if (head.path().starts_with(kControl)) return check_control(head, rules);
  if (head.path() == kWhatIf && is_of_another_site(head)) {
    return Refusal{403, "a page of another site may not have this machine plan", "use the page of this server"};
  }
  return std::nullopt;
}

}  // namespace ctn::web
