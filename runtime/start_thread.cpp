#include "runtime/start_thread.h"

#include <errno.h>

#include <cstdio>
#include <cstdlib>

#include "runtime/standard_streams.h"

namespace hapton {

void end_without_thread(const std::system_error& rejection) {
  std::fflush(stdout);
  print_text(stderr, "{}: cannot start another thread ({}); raise the user's limit (ulimit -u) or the unit's (TasksMax=)\n",
             program_invocation_short_name, rejection.code().message());
  std::_Exit(EXIT_FAILURE);
}

}  // namespace hapton
