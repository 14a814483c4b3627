#include "capi/failure.h"

#include <fmt/format.h>

namespace ctn::capi {
namespace {

// For when there is no memory to say so.
catan_error g_no_memory{CATAN_ENVIRONMENT, "no memory left"};

}  // namespace

catan_status fail(catan_error** out, catan_status status, const char* message) noexcept {
  if (out == nullptr) return status;
  try {
    *out = new catan_error{status, message};
  } catch (...) {
    *out = &g_no_memory;
  }
  return status;
}

catan_status fail(catan_error** out, const Error& error) noexcept {
  const catan_status status = error.kind() == ErrorKind::kCaller ? CATAN_CALLER : CATAN_ENVIRONMENT;
  try {
    return fail(out, status, error.message().c_str());
  } catch (...) {
    if (out != nullptr) *out = &g_no_memory;
    return status;
  }
}

Error missing(const char* argument) {
  return Error::caller(fmt::format("{} is NULL", argument), "pass what is required");
}

}  // namespace ctn::capi

uint32_t catan_version() { return CATAN_VERSION; }

const char* catan_error_message(const catan_error* error) { return error == nullptr ? "" : error->message.c_str(); }
catan_status catan_error_status(const catan_error* error) { return error == nullptr ? CATAN_OK : error->status; }
void catan_error_free(catan_error* error) {
  if (error != &ctn::capi::g_no_memory) delete error;
}
