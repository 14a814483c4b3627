// A record as a trace for Perfetto (docs/export.md): which subchain had each core, what each subchain and node did,
// which run took which as input, and response and compute times beside what was planned.
//
// Memory: that of the writer (trace_writer.h) and of record/lineage.h, and of open slices. It grows with the number of
// plans and notices, but not otherwise with the length of the record.
#pragma once

#include "base/result.h"
#include "export/output.h"
#include "record/reader.h"

namespace ctn::exports {

// Errors: those of the reader and of the sink; a plan in the record that cannot be read (kCaller).
Status write_perfetto(const record::Reader& record, const Sink& sink, const Progress& progress);

}  // namespace ctn::exports
