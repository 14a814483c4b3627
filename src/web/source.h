// What the page shows and may change. The server asks for it through this interface, so that it knows no scheduler, and
// tests can stand in for one.
//
// Thread safety: several threads call it, but no function is called by two at once. Cost: the server keeps each
// document for half a second, however many clients ask for it. An answer may take two seconds, during which only
// clients that ask for the same document wait. Answers of what_if() are not kept.
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
  // (docs/plan-schema.md). kEnvironment: the document is not available at present.
  virtual Result<std::string> live() = 0;
  virtual Result<std::string> timeline() = 0;
  virtual Result<std::string> snapshot() = 0;
  virtual Result<std::string> plan() = 0;

  // kCaller: the change is refused.
  virtual Status change(const Changes& changes) = 0;

  // JSON (docs/http.md): what would be planned. Nothing is changed. It may take some seconds. kCaller: the question
  // does not fit the app, or there is no plan for it.
  virtual Result<std::string> what_if(const WhatIf& asked) = 0;
};

}  // namespace ctn::web
