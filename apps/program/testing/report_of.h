// What the command says of a record that a program has written. CATAN_COMMAND is its path.
#pragma once

#include <cstdio>
#include <string>

#include <nlohmann/json.hpp>

#include "program/testing/run_command.h"

namespace ctn::program::testing {

// As JSON; no document where there is no such record. The record is removed.
inline nlohmann::json report_of(const std::string& record) {
  const Ended ended = run_command("'" CATAN_COMMAND "' report --json " + record);
  std::remove(record.c_str());
  return nlohmann::json::parse(ended.code == 0 ? ended.out : "", nullptr, false);
}

}  // namespace ctn::program::testing
