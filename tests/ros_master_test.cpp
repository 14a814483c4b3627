// What `catan ros bind` understands of a ROS master's answers.
#include "ros_master.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ctn::tool {
namespace {

XmlRpcValue text(const std::string& text) { return {text, {}}; }
XmlRpcValue list(std::vector<XmlRpcValue> values) { return {"", std::move(values)}; }

std::string response(const std::string& value) {
  return "HTTP/1.0 200 OK\r\nContent-type: text/xml\r\n\r\n<?xml "
         "version='1.0'?>\n<methodResponse>\n<params>\n<param>\n" +
         value + "\n</param>\n</params>\n</methodResponse>\n";
}

TEST(ParseXmlRpc, ListsAndTextOfAllTypes) {
  const std::string value =
      "<value><array><data>\n<value><int>1</int></value>\n<value><string>current state</string></value>\n"
      "<value><array><data>\n<value>/scan</value>\n<value><array><data>\n</data></array></value>\n</data></array></"
      "value>\n"
      "<value><string></string></value>\n</data></array></value>";
  EXPECT_EQ(parse_xml_rpc(response(value)),
            list({text("1"), text("current state"), list({text("/scan"), list({})}), text("")}));
}

TEST(ParseXmlRpc, WhatIsCutOffOrNoneIsNoValue) {
  const std::string whole = response("<value><array><data><value><int>1</int></value></data></array></value>");
  ASSERT_TRUE(parse_xml_rpc(whole));
  const std::size_t begin = whole.find("<value>");
  const std::size_t end = whole.rfind("</value>");
  for (std::size_t size = 0; size < end + 7; ++size) {
    EXPECT_FALSE(parse_xml_rpc(whole.substr(0, size))) << whole.substr(begin, size);
  }
  EXPECT_FALSE(parse_xml_rpc("<html>404</html>"));
  EXPECT_FALSE(parse_xml_rpc(response("<fault></fault>")));
}

TEST(ParseXmlRpc, DepthIsLimited) {
  std::string deep;
  for (int level = 0; level < 100'000; ++level) deep += "<value><array><data>";
  EXPECT_FALSE(parse_xml_rpc(response(deep)));
}

TEST(ParseHttpPlace, HostAndPort) {
  const auto place = parse_http_place("http://robot:11311/");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->host, "robot");
  EXPECT_EQ(place->port, "11311");
  EXPECT_TRUE(parse_http_place("http://localhost:1"));
  for (const char* const other : {"", "robot:11311", "http://", "http://robot", "http://:1", "http://robot:"}) {
    EXPECT_FALSE(parse_http_place(other)) << other;
  }
}

TEST(RosMaster, WhereNoneAnswersTheErrorSaysWhatToDo) {
  const auto connections = RosMaster("http://localhost:1").connections();
  ASSERT_FALSE(connections);
  EXPECT_EQ(connections.error().kind(), ErrorKind::kEnvironment);
  EXPECT_EQ(
      connections.error().message(),
      "no ROS master answers at http://localhost:1; start roscore, or roslaunch, which starts one; ROS_MASTER_URI "
      "says where it is");
  EXPECT_EQ(RosMaster("nonsense").node("/node"), RosMaster::Node::kUnknown);
}

}  // namespace
}  // namespace ctn::tool
