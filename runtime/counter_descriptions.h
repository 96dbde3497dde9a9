#pragma once

#include <span>
#include <string_view>

namespace hapton {

// What a counter of a report counts: one sentence, the same in the HELP of its metric and in docs/counters.md (a test compares them).
struct CounterDescription {
  std::string_view name;
  std::string_view text;
};

// Every counter of io_node's report. RT: yes.
std::span<const CounterDescription> counter_descriptions();

// The text for the counter of this name; empty if io_node's report has no such counter.
std::string_view describe_counter(std::string_view name);

}  // namespace hapton
