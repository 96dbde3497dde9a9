#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "link/messages.h"

namespace hapton {

// A marker with a random request number. Error, one line: the text is empty, too long, or has a character that MarkerText rejects. RT: no.
Result<Marker> make_marker(std::string_view text);

// The number of the sample that was marked. Error, one line: why none was marked.
Result<std::uint64_t> read_reply(const MarkerReply& reply);

}  // namespace hapton
