// What programs say to a server (server.h) and it to them, over its socket: one JSON object a message. It is said when
// a node comes or goes, never on the hot path; for that there is the region (region.h).
//
//   {"hello": {"version": 2, "thread": 41}}     first, once: `thread` serves the connection and belongs to no node.
//                                               Answered with the region's descriptor
//   {"join": {"node": "LM", "thread": 42}}      the sender runs this node, in this thread
//   {"add": {"node": "LM", "thread": 43}}       another thread that works for the node; "": for all of the sender's
//   {"leave": {"node": "LM"}}                   the sender runs it no more
// Each is answered, in order: {"done": {}} or {"refused": {"what": "...", "hint": "..."}}.
//
// A program that controls the server (`catan ctl`) says some of these, and no hello:
//   {"app": {"version": 2}}                     answered with {"done": {"app": "robot"}}: said first to a server that
//                                               was not named by its socket
//   {"change": {"version": 2, "cpus": [0, 1], "weights": [["scan -> LM", 0.5]], "maxes": [["0", 60.0]],
//               "min_rates": [["GL", null]]}}   catan/changes.h; what stays is left out. Answered as above
//   {"status": {"version": 2}}                  answered with {"done": {}}, and with memory that holds the length of a
//                                               text, in eight bytes, and the text: a snapshot as JSON
//   {"flight": {"version": 2}}                  answered with {"done": {}}, and with the memory in which the last
//                                               seconds are kept, to be read (flight/recording.h)
//
// Whatever is said more than this is not understood, and refused. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"
#include "catan/changes.h"

namespace ctn::runtime {

constexpr std::int32_t kProtocolVersion = 2;

struct Request {
  enum class Kind { kHello, kJoin, kAdd, kLeave, kApp, kChange, kStatus, kFlight };
  Kind kind = Kind::kHello;
  std::int32_t version = kProtocolVersion;  // kHello, kApp, kChange, kStatus, kFlight
  std::string node{};                       // kJoin, kAdd, kLeave; kAdd: empty where it is for all
  std::int32_t thread = 0;                  // kHello, kJoin, kAdd; > 0
  Changes changes{};                        // kChange
  friend bool operator==(const Request&, const Request&) = default;
};

std::string to_text(const Request& request);
// kCaller: what is not understood.
Result<Request> parse_request(std::string_view text);

std::string to_text(const Status& reply);
// The status that was sent; kEnvironment where that cannot be understood.
Status parse_reply(std::string_view text);

// The answer to kApp where it is granted.
std::string app_reply(const std::string& app);
// The app's name. Errors: as parse_reply() has them.
Result<std::string> parse_app_reply(std::string_view text);

}  // namespace ctn::runtime
