#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace hapton {

// Bytes of the character that begins there; 0: it is not UTF-8 (RFC 3629, table 3-7 of the Unicode standard). RT: yes.
std::size_t utf8_length(std::string_view text) noexcept;

// The text, with bytes that are not UTF-8 taken for Latin-1: names of files may be any bytes. RT: no.
std::string to_valid_utf8(std::string_view text);

}  // namespace hapton
