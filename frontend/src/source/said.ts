/*Message that is displayed after a reload of the page. */

const NAME = "jousto-said";

export function keep(message: string): void {
  try {
    sessionStorage.setItem(NAME, message);
  } catch {
    // browsers without session storage
  }
}

export function kept(): string {
  try {
    const message = sessionStorage.getItem(NAME) ?? "";
    sessionStorage.removeItem(NAME);
    return message;
  } catch {
    return "";
  }
}
