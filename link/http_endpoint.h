#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// The text at http://TO/TARGET, no TLS: for services on this machine. At most 64 KiB.
// Error: no listener, no reply in time, or one other than 200; one line without the address. RT: no.
Result<std::string> read_http(const Address& to, std::string_view target, std::int64_t timeout_ns);

}  // namespace hapton
