#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "link/messages.h"

namespace hapton {

// The hub's report as it is now: report.json and latency.csv as text, both of the same moment.
struct HubReport {
  std::string json;
  std::string csv;
};

// Sits at a hub as a tool and reads its report, part by part, over the wire.
// RT: no. Threads: one.
class HubReader {
 public:
  // hub: HOST or HOST:PORT. Error: one line: bad address or key, no reply from the hub.
  static Result<std::unique_ptr<HubReader>> open(const std::string& hub, const std::string& key_file);

  ~HubReader();
  HubReader(const HubReader&) = delete;
  HubReader& operator=(const HubReader&) = delete;

  // A fresh report. Error: the hub does not reply, or has none.
  Result<HubReport> read();

  // Keeps the connection to the hub alive for the given time; false if the hub no longer replies.
  bool idle(double seconds);

 private:
  struct State;
  explicit HubReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hapton
