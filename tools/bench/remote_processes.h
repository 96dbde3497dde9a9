#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/bench/remote_grid.h"
#include "tools/bench/remote_recording.h"

namespace hapton {

// One case of the grid with its method, measured with the real programs and in simulated time.
struct RemoteProcessRow : RemoteKey {
  RecordedTouch real;
  PrescribedTouch simulated;  // its `rows` are empty
};

// Whether the programs implement the method: remote, remote-passive, patch and patch-passive. With the programs all of these have the
// governor; in the simulation only remote has it. RT: yes.
bool is_implemented_by_programs(const RemoteMethod& method) noexcept;

// Runs hub, relay and haptics node of this build on this host for every case of the grid at 1 kHz. The hand follows a trajectory, whatever
// the force (io_node --device replay). Needs a machine with two CPUs that does nothing else. progress: called with one line after each
// case. Error, one line: a program failed, or the programs do not implement one of the methods. RT: no.
Result<std::vector<RemoteProcessRow>> measure_remote_processes(const RemoteGrid& grid,
                                                               const std::function<void(const std::string&)>& progress);

// The results as a table, as CSV and as JSON. RT: no.
std::string processes_to_text(const RemoteGrid& grid, const std::vector<RemoteProcessRow>& rows);
std::string processes_to_csv(const std::vector<RemoteProcessRow>& rows);
// Schema hapton.bench.remote_processes/1.
std::string processes_to_json(const RemoteGrid& grid, const std::vector<RemoteProcessRow>& rows);

}  // namespace hapton
