#pragma once

namespace hapton {

// Tells the CPU that this thread is spinning. RT: yes.
inline void spin_pause() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace hapton
