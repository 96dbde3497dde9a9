#include "bench/peers/tool_peers.h"

namespace hapton {

std::vector<SixdofMethodKind> tool_peers() {
  std::vector<SixdofMethodKind> kinds;
#ifdef HAPTON_HAS_BULLET
  kinds.push_back(bullet_tool());
#endif
#ifdef HAPTON_HAS_FCL
  kinds.push_back(fcl_tool());
#endif
  return kinds;
}

std::vector<std::string> missing_tool_peers() {
  std::vector<std::string> missing;
#ifndef HAPTON_HAS_BULLET
  missing.emplace_back("bullet");
#endif
#ifndef HAPTON_HAS_FCL
  missing.emplace_back("fcl");
#endif
  return missing;
}

}  // namespace hapton
