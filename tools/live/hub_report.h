#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "link/messages.h"

namespace hapton {

// The hub's report at one moment: the text of report.json and of latency.csv.
struct HubReport {
  std::string json;
  std::string csv;
};

// Joins a hub in the role `tool` and requests its report, which comes in several datagrams.
// RT: no. Threads: one.
class HubReader {
 public:
  // hub: HOST or HOST:PORT. Error: one line: bad address or key, no reply from the hub.
  static Result<std::unique_ptr<HubReader>> open(const std::string& hub, const std::string& key_file);

  ~HubReader();
  HubReader(const HubReader&) = delete;
  HubReader& operator=(const HubReader&) = delete;

  // Requests a new report and waits for it. Error: the hub does not reply, or has no report.
  Result<HubReport> read();

  // Keeps the connection to the hub alive for the given time; returns false if the hub no longer replies.
  bool idle(double seconds);

 private:
  struct State;
  explicit HubReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hapton
