#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace hapton {

// Bytes in the first character; 0: it is not UTF-8 (RFC 3629, table 3-7 of the Unicode standard). Pre: text is not empty. RT: yes.
std::size_t utf8_length(std::string_view text) noexcept;

// The text, with bytes that are not UTF-8 read as Latin-1, because file names may contain any bytes. RT: no.
std::string to_valid_utf8(std::string_view text);

}  // namespace hapton
