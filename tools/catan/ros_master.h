// What a ROS 1 master knows of the system that runs, asked by its API (XML-RPC over HTTP): which nodes publish and
// subscribe which topics, and which of them are written in Python.
//
// Thread safety: one thread. Every call ends within a few seconds, whatever answers.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "common/inferred_graph.h"

namespace ctn::tool {

// A value of XML-RPC, as far as a master's answers need it: text, or a list of values. Numbers are text.
struct XmlRpcValue {
  std::string text{};
  std::vector<XmlRpcValue> list{};

  friend bool operator==(const XmlRpcValue&, const XmlRpcValue&) = default;
};

// The value that a whole methodResponse has; none: it has none, or is no such document.
std::optional<XmlRpcValue> parse_xml_rpc(std::string_view document);
// http://HOST:PORT, with or without a slash.
struct HttpPlace {
  std::string host;
  std::string port;
};
std::optional<HttpPlace> parse_http_place(std::string_view uri);

class RosMaster {
 public:
  // By ROS_MASTER_URI, else where roscore is unless it is told otherwise.
  static RosMaster from_environment();
  explicit RosMaster(std::string uri) : uri_(std::move(uri)) {}

  const std::string& uri() const { return uri_; }
  // kEnvironment: none answers there.
  Result<catan_ros::Connections> connections() const;
  enum class Node { kUnknown, kPython, kOther };  // kPython: a program of this machine that Python runs
  Node node(const std::string& name) const;

 private:
  std::string uri_;
};

}  // namespace ctn::tool
