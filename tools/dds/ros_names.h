#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton::dds {

// The highest DDS domain whose port numbers are below 65,536. Source: RTPS 2.2, 9.6.1.
constexpr int kHighestDomain = 232;

// The prefix of all topics: "/arm/pen" for "arm/pen" or "/arm/pen". Error, one line: it is longer than 200 characters, or no ROS 2 name
// (words of letters, digits and underscores between slashes, none beginning with a digit, no two underscores in a row). Source: ROS 2
// design, "Topic and Service name mapping to DDS". RT: no.
Result<std::string> make_prefix(std::string_view prefix);

// The DDS topic of a ROS 2 topic: "rt/pen/measured_cf" for "/pen/measured_cf". RT: no.
std::string dds_topic(std::string_view ros_topic);

// Error, one line: the frame name is empty or longer than 200 characters, begins with a slash, or has blanks or non-ASCII. RT: no.
Result<void> check_frame(std::string_view frame);

// Error, one line: the text cannot be the name or address of a network interface. Whether there is one is not checked. RT: no.
Result<void> check_interface(std::string_view interface);

// The domain: `domain_option`; without it ros_domain_id, the value of the variable ROS_DOMAIN_ID (null or empty: not set); without both 0.
// Error, one line: it is not a whole number from 0 to kHighestDomain. RT: no.
Result<int> choose_domain(std::optional<int> domain_option, const char* ros_domain_id);

}  // namespace hapton::dds
