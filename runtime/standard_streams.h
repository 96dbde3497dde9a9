#pragma once

#include "core/base/result.h"

namespace hapton {

// Opens those of stdin, stdout and stderr that are closed on /dev/null. Otherwise the next file or socket would take the number, and get
// what is printed. First line of every main. RT: set-up only.
void open_standard_streams();

// From now on a write to a pipe whose reader has gone fails, instead of ending the process: a node outlives whoever reads its log. RT:
// set-up only.
void outlive_readers();

// Whether all that was printed on stdout so far has arrived. Error: one line: it has not, as of a full disk. RT: no.
Result<void> flush_standard_output();

}  // namespace hapton
