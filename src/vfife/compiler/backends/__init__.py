"""The step as text: LLVM, PTX, JavaScript, Python."""
