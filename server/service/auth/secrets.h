#pragma once

#include <array>
#include <string>
#include <string_view>

namespace kerf::auth {

// A SHA-256.
using Digest = std::array<unsigned char, 32>;

Digest digest_of(std::string_view text);
// Compares in a time that does not depend on where the two differ.
bool are_equal(const Digest& a, const Digest& b);
std::string to_hex(const Digest& digest);

// Returns 256 random bits of the operating system as 43 characters of A-Z, a-z, 0-9, - and _.
std::string new_secret();

}  // namespace kerf::auth
