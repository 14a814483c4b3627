// The error types are part of the public API; the modules reach them through here.
#pragma once

#include "catan/result.h"  // IWYU pragma: export
