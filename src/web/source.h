// What a page shows, and what it may change: the server asks for it here, so that it knows no scheduler, and tests can
// play one.
//
// Thread safety: called by several threads, but no function by two at once. Cost: the server keeps each answer for half
// a second, however many clients ask; an answer may take two seconds, in which only those wait that ask for the same.
// Only what_if() is asked each time.
#pragma once

#include <string>

#include "base/result.h"
#include "catan/changes.h"
#include "web/what_if.h"

namespace ctn::web {

class Source {
 public:
  virtual ~Source() = default;

  // JSON documents: what happens at present (as `catan top --once --json` prints it), the timelines of the last 30
  // seconds (timeline.h), what was measured (as `catan ctl status --json` prints it), the plan in force
  // (docs/plan-schema.md). kEnvironment: there is nothing to be had at present.
  virtual Result<std::string> live() = 0;
  virtual Result<std::string> timeline() = 0;
  virtual Result<std::string> snapshot() = 0;
  virtual Result<std::string> plan() = 0;

  // kCaller: it is refused.
  virtual Status change(const Changes& changes) = 0;

  // JSON (docs/http.md): what would be planned, and nothing is changed. It may take some seconds. kCaller: what is
  // asked cannot be, or cannot be planned.
  virtual Result<std::string> what_if(const WhatIf& asked) = 0;
};

}  // namespace ctn::web
