#include "tools/session/cycle_files.h"

#include "recording/recording_entries.h"

namespace hapton {

ObjectChanges add_all(SessionReader& reader, CycleTable& table, const OnEntry& on_entry) {
  ObjectChanges changes(reader.header().start_ns);
  (void)for_each_entry(reader, [&](const SessionEntry& entry, const Datagram* datagram) -> Result<void> {
    table.add(entry, datagram);
    changes.add(entry, datagram);
    if (on_entry) on_entry(entry, datagram);
    return {};
  });
  table.finish();
  changes.finish();
  return changes;
}

}  // namespace hapton
