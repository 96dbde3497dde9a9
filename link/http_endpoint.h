#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// Body (at most 64 KiB) of the reply to GET http://TO + target ("/version"), without TLS: for services on this machine. timeout_ns: from
// connection to reply. Error, one line without the address: no listener, no reply in time, or an HTTP status other than 200. RT: no.
Result<std::string> read_http(const Address& to, std::string_view target, std::int64_t timeout_ns);

}  // namespace hapton
