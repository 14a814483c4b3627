// What the command lines of the apps' programs have in common.
//
// Thread safety: pure functions, but for what they read of the file system.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "program/leave.h"

namespace ctn::program {

// Nothing: the words are right, and the app's variables have what they say. The program's name is the app's.
std::optional<Leave> parse(CLI::App& app, int argc, const char* const* argv);

// What --cpus says, if anything, as in "0", "0,2" or "0-3,6": ascending and without doubles. Returns what is wrong with
// it.
std::optional<std::string> take_cpus(const std::string& text, std::vector<int>& cpus);

// For a mistake that parse() does not know of.
Leave leave_over(const std::string& program, const std::string& mistake);

// As CLI::Range, which lets NaN through.
CLI::Validator within(double min, double max);

// The option --calibration, which stores its value in `file`. `in_virtual_time`: the option --virtual.
void add_calibration(CLI::App& app, std::string& file, CLI::Option* in_virtual_time);

// The path of a file that belongs to the program: beside it (the build tree), or where it was installed to.
std::string file_of_the_app(const std::string& name);

}  // namespace ctn::program
