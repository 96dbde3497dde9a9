#pragma once

// Mailbox is in core because force methods use it too: between their slow and their fast task.
#include "core/base/mailbox.h"
