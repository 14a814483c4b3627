#include "ros_master.h"

#include <fmt/format.h>
#include <netdb.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <utility>

#include "os/linux/files.h"
#include "os/linux/linux_os.h"
#include "os/linux/tcp.h"

namespace ctn::tool {
namespace {

constexpr const char* kUsualMaster = "http://localhost:11311";
constexpr const char* kOwnName = "/catan_ros_bind";
constexpr std::chrono::seconds kAnswer{2};
constexpr std::size_t kMaxAnswer = std::size_t{16} << 20U;
constexpr int kMaxDepth = 16;

// --- XML-RPC ---

class XmlReader {
 public:
  explicit XmlReader(std::string_view text) : text_(text) {}

  // Goes behind the next such tag; false: there is none.
  bool skip_past(std::string_view tag) {
    const std::size_t found = text_.find(tag, at_);
    if (found == std::string_view::npos) return false;
    at_ = found + tag.size();
    return true;
  }

  // Behind a <value>, up to and including its </value>.
  std::optional<XmlRpcValue> read_value(int depth) {
    if (depth > kMaxDepth) return std::nullopt;
    skip_blanks();
    XmlRpcValue value;
    if (starts_with("<array")) {
      if (!skip_past("<data>"))
        return starts_with("<array/>") && skip_past("</value>") ? std::optional(value) : std::nullopt;
      for (skip_blanks(); !starts_with("</data>"); skip_blanks()) {
        if (!starts_with("<value>") || !skip_past("<value>")) return std::nullopt;
        std::optional<XmlRpcValue> element = read_value(depth + 1);
        if (!element) return std::nullopt;
        value.list.push_back(std::move(*element));
      }
    } else {
      if (starts_with("<")) skip_past(">");  // the type
      const std::size_t end = text_.find('<', at_);
      if (end == std::string_view::npos) return std::nullopt;
      value.text = text_.substr(at_, end - at_);
      at_ = end;
    }
    return skip_past("</value>") ? std::optional(std::move(value)) : std::nullopt;
  }

 private:
  bool starts_with(std::string_view what) const { return text_.substr(at_).starts_with(what); }
  void skip_blanks() {
    const std::size_t next = text_.find_first_not_of(" \t\r\n", at_);
    at_ = next == std::string_view::npos ? text_.size() : next;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

std::string http_request(const std::string& method, const std::vector<std::string>& arguments, const HttpPlace& place) {
  std::string body = fmt::format("<?xml version=\"1.0\"?><methodCall><methodName>{}</methodName><params>", method);
  for (const std::string& argument : arguments) {
    body += fmt::format("<param><value><string>{}</string></value></param>", argument);
  }
  body += "</params></methodCall>";
  return fmt::format("POST / HTTP/1.0\r\nHost: {}:{}\r\nContent-Type: text/xml\r\nContent-Length: {}\r\n\r\n{}",
                     place.host, place.port, body.size(), body);
}

// The host may be a name here, which os::TcpConnection does not look up.
std::optional<os::TcpAddress> look_up(const HttpPlace& place) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(place.host.c_str(), place.port.c_str(), &hints, &found) != 0) return std::nullopt;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owned(found, ::freeaddrinfo);
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  if (::getnameinfo(found->ai_addr, found->ai_addrlen, host.data(), host.size(), port.data(), port.size(),
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return std::nullopt;
  }
  const auto address = os::parse_tcp_address(fmt::format("{}:{}", host.data(), port.data()));
  return address ? std::optional(*address) : std::nullopt;
}

// The third part of the answer, which is what was asked for; none: no answer, or an error.
std::optional<XmlRpcValue> ask(const std::string& uri, const std::string& method,
                               const std::vector<std::string>& arguments) {
  const std::optional<HttpPlace> place = parse_http_place(uri);
  const std::optional<os::TcpAddress> address = place ? look_up(*place) : std::nullopt;
  if (!address) return std::nullopt;
  const TimePoint deadline = os::make_linux_os()->now() + kAnswer;
  const auto connection = os::TcpConnection::connect(*address, deadline);
  if (!connection) return std::nullopt;
  if (connection->send(http_request(method, arguments, *place), deadline) != os::TcpConnection::Outcome::kDone) {
    return std::nullopt;
  }
  std::string answer;
  std::array<char, 16384> part{};
  while (answer.size() < kMaxAnswer && answer.find("</methodResponse>") == std::string::npos) {
    const auto received = connection->receive(part.data(), part.size(), deadline);
    if (received.outcome != os::TcpConnection::Outcome::kDone || received.bytes == 0) break;
    answer.append(part.data(), received.bytes);
  }
  std::optional<XmlRpcValue> value = parse_xml_rpc(answer);
  // [1, what it says of it, the result]
  if (!value || value->list.size() != 3 || value->list[0].text != "1") return std::nullopt;
  return std::move(value->list[2]);
}

// A list of [topic, [node, ...]].
std::map<std::string, std::vector<std::string>> nodes_by_topic(const XmlRpcValue& value) {
  std::map<std::string, std::vector<std::string>> topics;
  for (const XmlRpcValue& entry : value.list) {
    if (entry.list.size() != 2) continue;
    for (const XmlRpcValue& node : entry.list[1].list) topics[entry.list[0].text].push_back(node.text);
  }
  return topics;
}

}  // namespace

std::optional<XmlRpcValue> parse_xml_rpc(std::string_view document) {
  XmlReader reader(document);
  if (!reader.skip_past("<methodResponse>") || !reader.skip_past("<param>") || !reader.skip_past("<value>")) {
    return std::nullopt;
  }
  return reader.read_value(0);
}

std::optional<HttpPlace> parse_http_place(std::string_view uri) {
  constexpr std::string_view kScheme = "http://";
  if (!uri.starts_with(kScheme)) return std::nullopt;
  uri.remove_prefix(kScheme.size());
  if (!uri.empty() && uri.back() == '/') uri.remove_suffix(1);
  const std::size_t colon = uri.rfind(':');
  if (colon == std::string_view::npos || colon == 0 || colon + 1 == uri.size()) return std::nullopt;
  return HttpPlace{std::string(uri.substr(0, colon)), std::string(uri.substr(colon + 1))};
}

RosMaster RosMaster::from_environment() {
  const char* const uri = std::getenv("ROS_MASTER_URI");
  return RosMaster(uri != nullptr && *uri != '\0' ? uri : kUsualMaster);
}

Result<catan_ros::Connections> RosMaster::connections() const {
  const std::optional<XmlRpcValue> state = ask(uri_, "getSystemState", {kOwnName});
  if (!state || state->list.size() != 3) {
    return Error::environment(fmt::format("no ROS master answers at {}", uri_),
                              "start roscore, or roslaunch, which starts one; ROS_MASTER_URI says where it is");
  }
  return catan_ros::Connections{nodes_by_topic(state->list[0]), nodes_by_topic(state->list[1])};
}

RosMaster::Node RosMaster::node(const std::string& name) const {
  const std::optional<XmlRpcValue> uri = ask(uri_, "lookupNode", {kOwnName, name});
  if (!uri) return Node::kUnknown;
  const std::optional<XmlRpcValue> process = ask(uri->text, "getPid", {kOwnName});
  if (!process || !os::parse_integer(process->text)) return Node::kOther;
  std::error_code failed;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/" + process->text + "/exe", failed);
  return program.filename().string().starts_with("python") ? Node::kPython : Node::kOther;
}

}  // namespace ctn::tool
