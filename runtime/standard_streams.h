#pragma once

#include "core/base/result.h"

namespace hapton {

// Opens those of stdin, stdout and stderr that are closed on /dev/null. Otherwise the next file or socket would take the number, and get
// what is printed. First line of every main. RT: set-up only.
void open_standard_streams();

// Whether all that was printed on stdout so far has arrived. Error: one line: it has not, as of a full disk. RT: no.
Result<void> flush_standard_output();

}  // namespace hapton
