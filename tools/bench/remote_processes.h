#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/bench/remote_grid.h"
#include "tools/bench/remote_recording.h"

namespace hapton {

// A cell of the grid twice: over the real programs, and in simulated time.
struct RemoteProcessRow : RemoteKey {
  RecordedTouch real;
  PrescribedTouch simulated;  // without its rows
};

// The methods that the programs have: remote, remote-passive, patch and patch-passive. The last three as the lab has them, but with the
// governor that no program is without. RT: yes.
bool is_implemented_by_programs(const RemoteMethod& method) noexcept;

// Runs hub, relay and haptics node of this build on this host for every cell of the grid, the hand a trajectory that is played whatever the
// force (io_node --device replay), 1 kHz. Needs a quiet machine with two CPUs. Error: one line; a method without programs. RT: no.
Result<std::vector<RemoteProcessRow>> measure_remote_processes(const RemoteGrid& grid,
                                                               const std::function<void(const std::string&)>& progress);

// RT: no.
std::string processes_to_text(const RemoteGrid& grid, const std::vector<RemoteProcessRow>& rows);
std::string processes_to_csv(const std::vector<RemoteProcessRow>& rows);
// Schema hapton.bench.remote_processes/1.
std::string processes_to_json(const RemoteGrid& grid, const std::vector<RemoteProcessRow>& rows);

}  // namespace hapton
