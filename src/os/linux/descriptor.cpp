#include "os/linux/descriptor.h"

#include <unistd.h>

#include <cerrno>

namespace ctn::os {

// Keeps errno, so that a failed call can be reported after its descriptors are gone. Linux frees the number whatever
// close() returns; a second try might hit another thread's.
void Descriptor::reset() {
  if (!valid()) return;
  const int error = errno;
  ::close(release());
  errno = error;
}

}  // namespace ctn::os
