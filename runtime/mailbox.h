#pragma once

// The slow and the fast task of a force method exchange through it too, so it lives in the core.
#include "core/base/mailbox.h"
