// C++ compares the version of the header with that of the library.

#include <cstring>
#include <iostream>

#include "hexcast.h"

int main() {
  static_assert(HEXCAST_VERSION_MAJOR >= 0 && HEXCAST_VERSION_MINOR >= 0 && HEXCAST_VERSION_PATCH >= 0, "numbers");
  std::cout << hexcast_version() << '\n';
  return std::strcmp(hexcast_version(), HEXCAST_VERSION_STRING) == 0 ? 0 : 1;
}
