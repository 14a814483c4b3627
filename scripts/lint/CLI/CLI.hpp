// In front of CLI11 for `make lint` alone (scripts/lint.sh), where it halves the time that clang-tidy takes for what
// reads a command line. For each parameter that could be taken by reference (CLI11 has 120) it searches all of the
// source for other uses of the function before it proposes to change it, even in a header whose warnings nobody sees;
// what comes out of a macro it does not propose to change.
#pragma GCC system_header
#define std std
#include_next <CLI/CLI.hpp>
#undef std
