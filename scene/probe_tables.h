#pragma once

#include <vector>

#include "core/base/result.h"
#include "scene/probe_reader.h"
#include "scene/table_reader.h"

namespace hapton {

// The tables [[probe]] of a scene file; empty: none. RT: set-up only. Error: one line with the line in the file.
Result<std::vector<ProbeSpec>> read_probes(const toml::table& scene);

}  // namespace hapton
