#include "bench/peers/peer_structures.h"

#include <iterator>
#include <utility>

namespace hapton {
namespace {

struct Peer {
  const char* name;
  std::vector<QueryStructureKind> (*structures)();
};

std::vector<Peer> built_peers() {
  std::vector<Peer> peers;
#ifdef HAPTON_HAS_EMBREE
  peers.push_back({"embree", embree_structures});
#endif
#ifdef HAPTON_HAS_CGAL
  peers.push_back({"cgal", cgal_structures});
#endif
#ifdef HAPTON_HAS_FCL
  peers.push_back({"fcl", fcl_structures});
#endif
#ifdef HAPTON_HAS_VTK
  peers.push_back({"vtk", vtk_structures});
#endif
  return peers;
}

}  // namespace

std::vector<QueryStructureKind> peer_structures() {
  std::vector<QueryStructureKind> kinds;
  for (const Peer& peer : built_peers()) {
    for (QueryStructureKind& kind : peer.structures()) {
      kind.library = peer.name;
      kinds.push_back(std::move(kind));
    }
  }
  return kinds;
}

std::vector<std::string> missing_peers() {
  std::vector<std::string> missing = {"embree", "cgal", "fcl", "vtk"};
  for (const Peer& peer : built_peers()) std::erase(missing, peer.name);
  return missing;
}

}  // namespace hapton
