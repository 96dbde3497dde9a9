#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton::dds {

// The largest domain for whose ports there is room below 65,536. Source: RTPS 2.2, 9.6.1.
constexpr int kHighestDomain = 232;

// "/arm/pen" for "arm/pen" or "/arm/pen". Error: one line: not a name that ROS 2 takes (words of letters, digits and underscores between
// slashes, none beginning with a digit, no two underscores in a row). Source: ROS 2 design, "Topic and Service name mapping to DDS". RT:
// no.
Result<std::string> make_prefix(std::string_view prefix);

// The DDS topic of a ROS 2 topic: "rt/pen/measured_cf" for "/pen/measured_cf". RT: no.
std::string dds_topic(std::string_view ros_topic);

// Error: one line: not a frame that tf2 takes: empty, beginning with a slash, or with blanks or control characters. RT: no.
Result<void> check_frame(std::string_view frame);

// Error: one line: neither a name nor an address of a network interface. RT: no.
Result<void> check_interface(std::string_view interface);

// given, or what ROS_DOMAIN_ID (null: not set) says, or 0. Error: one line: not a whole number from 0 to kHighestDomain. RT: no.
Result<int> choose_domain(std::optional<int> given, const char* ros_domain_id);

}  // namespace hapton::dds
