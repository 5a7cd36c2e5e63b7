/* What Qt6Core.dll imports from Windows' icuuc.dll, which Wine does not have: always "no such converter", whereupon Qt
   does without. For the tests under Wine only; no package contains it. Built by packaging/windows/wine.py. */

#define EXPORT(result, name) \
    __declspec(dllexport) result name(void) { return 0; }

typedef void *pointer;

static const int FILE_ACCESS_ERROR = 4; /* U_FILE_ACCESS_ERROR */

__declspec(dllexport) pointer ucnv_open(const char *name, int *error) {
    (void)name;
    *error = FILE_ACCESS_ERROR;
    return 0;
}

EXPORT(int, UCNV_FROM_U_CALLBACK_SUBSTITUTE)
EXPORT(int, UCNV_TO_U_CALLBACK_SUBSTITUTE)
EXPORT(int, ucnv_cbFromUWriteUChars)
EXPORT(int, ucnv_cbToUWriteUChars)
EXPORT(int, ucnv_close)
EXPORT(int, ucnv_countAvailable)
EXPORT(int, ucnv_fromUCountPending)
EXPORT(int, ucnv_fromUnicode)
EXPORT(pointer, ucnv_getAvailableName)
EXPORT(int, ucnv_getFromUCallBack)
EXPORT(int, ucnv_getMaxCharSize)
EXPORT(pointer, ucnv_getName)
EXPORT(pointer, ucnv_getStandardName)
EXPORT(int, ucnv_getToUCallBack)
EXPORT(int, ucnv_reset)
EXPORT(int, ucnv_setFromUCallBack)
EXPORT(int, ucnv_setToUCallBack)
EXPORT(int, ucnv_toUCountPending)
EXPORT(int, ucnv_toUnicode)
