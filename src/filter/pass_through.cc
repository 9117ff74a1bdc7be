// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/pass_through.hpp"
